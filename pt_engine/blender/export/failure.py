"""What stops an export."""


class ExportError(RuntimeError):
    """The scene can't be rendered, and why."""
