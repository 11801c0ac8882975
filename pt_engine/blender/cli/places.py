"""Where results go: looked at before the work that makes them. Without Blender."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .failure import Failure


def check_writable(path: Path) -> None:
    """Fail now rather than after an hour's render. Missing folders are made."""
    try:
        if path.is_dir():
            raise IsADirectoryError("it is a directory")
        path.absolute().parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.absolute().parent):
            pass
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError("it is write-protected")
    except FileExistsError as error:
        raise Failure(f"can't write {path}: {error.filename} is not a folder") from error
    except OSError as error:
        raise Failure(f"can't write {path}: {error.strerror or error}") from error
