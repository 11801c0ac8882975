"""Everything that knows Blender: the engine, its panels, the export, the command line.

Importing this imports neither bpy nor embreex, so that a missing one is told in words.
"""


def register() -> None:
    """Make PT Engine known to Blender."""
    from . import registration

    registration.register()


def unregister() -> None:
    """Take PT Engine out of Blender again."""
    from . import registration

    registration.unregister()
