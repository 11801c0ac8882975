"""Where results go: looked at before the work that makes them. Without Blender."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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


@contextmanager
def written(path: Path) -> Iterator[None]:
    """A disk that is full, or a place that has gone meanwhile, is told in one line."""
    try:
        yield
    except OSError as error:
        raise Failure(f"can't write {path}: {error.strerror or error}") from error


def write_all(files: list[tuple[Path, Callable[[], object]]]) -> None:
    """Write each of them, though one before it could not be; then tell which could not."""
    failures = []
    for path, write in files:
        try:
            with written(path):
                write()
        except Failure as failure:
            failures.append(str(failure))
    if failures:
        raise Failure("; ".join(failures))
