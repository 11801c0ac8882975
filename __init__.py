"""Blender's way in: as an extension this folder is the add-on, and the package lies in it.

It does nothing but register and unregister; everything else is in pt_engine/.
"""


def register():
    """Called by Blender when the extension is enabled."""
    try:
        from .pt_engine.blender import register as register_engine

        register_engine()
    except ImportError as error:
        missing = (error.name or "").partition(".")[0]
        if missing not in ("embreex", "OpenImageIO"):
            raise
        raise RuntimeError(
            f"PT Engine needs the Python module {missing}, and it is not here. Install the zip built "
            "for this system and this version of Blender, or run scripts/build on this machine."
        ) from error


def unregister():
    """Called by Blender when the extension is disabled."""
    from .pt_engine.blender import unregister as unregister_engine

    unregister_engine()
