"""Films on disk: an .npz of plain arrays and a JSON header, never pickle, checked on the way in."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .film import Film

FORMAT = "pt_engine.film/2"


def save_film(film: Film, path: str | os.PathLike[str]) -> None:
    """Write `film` to exactly `path`; an existing file is replaced only by a complete one."""
    header = {
        "format": FORMAT, "width": film.width, "height": film.height, "key": film.key,
        "ranges": film.ranges, "dropped": film.dropped,
        "correlated": film.correlated, "halves": film.halves,
    }  # fmt: skip
    text = np.frombuffer(json.dumps(header).encode(), np.uint8)
    path = Path(path)
    partial = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with open(partial, "wb") as stream:
            np.savez(stream, header=text, **film.state())  # type: ignore[arg-type]
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def load_film(path: str | os.PathLike[str]) -> Film:
    """Read what `save_film` wrote.

    Raises
    ------
    OSError
        The file cannot be read.
    ValueError
        It is not a film, or a damaged one; the message says which file and what is wrong.
    """
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as arrays:
            header = json.loads(arrays["header"].tobytes())
            if header["format"] != FORMAT:
                raise ValueError(f"format {header['format']!r} is not {FORMAT!r}")
            film = Film(
                int(header["width"]),
                int(header["height"]),
                str(header["key"]),
                correlated=bool(header["correlated"]),
                halves=bool(header["halves"]),
            )
            n, rows = film.pixels, film.rows
            count_b = _array(arrays["count_b"], (n,), np.uint32) if film.halves else None
            alpha = _array(arrays["alpha"], (n,), np.float64) if "alpha" in arrays else None
            film.restore(
                _array(arrays["high"], (rows, n), np.float64),
                _array(arrays["low"], (rows, n), np.float64),
                _array(arrays["count"], (n,), np.uint32),
                count_b,
                alpha,
            )
            film.ranges = tuple((int(first), int(count)) for first, count in header["ranges"])
            film.dropped = int(header["dropped"])
            return film
    except (ValueError, KeyError, TypeError, zipfile.BadZipFile, EOFError) as problem:
        raise ValueError(f"{os.fspath(path)} is not a film of this version: {problem}") from problem


def _array(array: NDArray[Any], shape: tuple[int, ...], dtype: type) -> NDArray[Any]:
    if array.shape != shape or array.dtype != dtype:
        raise ValueError(f"an array has shape {array.shape} and type {array.dtype}, not {shape} of {dtype}")
    if not np.isfinite(array).all():
        raise ValueError("an array holds values that are not finite")
    return array
