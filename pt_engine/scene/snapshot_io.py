"""A snapshot as one file: a zip of ``snapshot.json`` and plain ``.npy`` members.

Never pickle: a snapshot from a stranger must not run code, nor crash the engine. Members are stored, not
compressed, so no array can be larger than the file; every class, field, type, shape and index is checked
before the snapshot is handed out, for an index past its array would be a wild read inside Embree.

The JSON is ``{"format": "pt_engine snapshot", "version": 1, "snapshot": tree}`` where a tree is a number, a
string, a boolean or null, or an object with one key that says what it is:

``{"array": k}`` member ``k.npy``    ``{"tuple": [...]}``    ``{"dict": [[key, value], ...]}``
``{"link": [node, socket]}``         ``{"float": "nan" | "inf" | "-inf"}``
``{"Mesh...Data", "Graph" ...: {field: tree, ...}}``   one of the dataclasses of `snapshot`
"""

from __future__ import annotations

import dataclasses
import io
import json
import math
import tokenize
import zipfile
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from . import snapshot as data
from .snapshot_check import CLASSES, SnapshotError, check

FORMAT = "pt_engine snapshot"
VERSION = 1
HEADER = "snapshot.json"
DTYPES = {np.dtype(name) for name in ("<f4", "<f8", "<i4", "|u1")}
MALFORMED = (  # what the standard library raises on broken files
    zipfile.BadZipFile,
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    OSError,
    RecursionError,
    RuntimeError,
    SyntaxError,
    tokenize.TokenError,  # numpy's, of an .npy header
    TypeError,
    ValueError,
)

__all__ = ["SnapshotError", "load_snapshot", "save_snapshot"]


def save_snapshot(snapshot: data.Snapshot, file: str | Path | BinaryIO) -> None:
    """Write a snapshot; what `load_snapshot` returns of it is equal bit for bit."""
    arrays: list[NDArray[Any]] = []
    numbers: dict[int, int] = {}
    tree = encode(snapshot, arrays, numbers)
    header = {"format": FORMAT, "version": VERSION, "snapshot": tree}
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        archive.writestr(member(HEADER), json.dumps(header, ensure_ascii=False, allow_nan=False))
        for number, array in enumerate(arrays):
            with archive.open(member(f"{number}.npy"), "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, array, allow_pickle=False)


def load_snapshot(file: str | Path | BinaryIO) -> data.Snapshot:
    """Read a snapshot back.

    Raises
    ------
    SnapshotError
        The file can't be read, isn't a snapshot, is damaged, or has been tampered with.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            return check(decode(read_header(archive), Members(archive)))
    except SnapshotError:
        raise
    except MALFORMED as error:
        raise SnapshotError(f"not a readable snapshot: {type(error).__name__}: {error}") from error


def member(name: str) -> zipfile.ZipInfo:
    """A member of a fixed date: equal snapshots make equal files."""
    return zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))


def encode(value: Any, arrays: list[NDArray[Any]], numbers: dict[int, int]) -> Any:
    """The JSON tree of a value; arrays go to `arrays`, the same one only once."""
    if isinstance(value, np.ndarray):
        return {"array": array_number(value, arrays, numbers)}
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    if isinstance(value, data.Link):
        return {"link": [value.node, value.socket]}
    if dataclasses.is_dataclass(value):
        fields = dataclasses.fields(value)
        return {
            type(value).__name__: {f.name: encode(getattr(value, f.name), arrays, numbers) for f in fields}
        }
    if isinstance(value, tuple | list):
        return {"tuple": [encode(item, arrays, numbers) for item in value]}
    if isinstance(value, dict):
        return {"dict": [[str(key), encode(item, arrays, numbers)] for key, item in value.items()]}
    raise SnapshotError(f"a snapshot can't hold a {type(value).__name__}")


def array_number(value: NDArray[Any], arrays: list[NDArray[Any]], numbers: dict[int, int]) -> int:
    """Number of an array among those to write."""
    if id(value) not in numbers:
        stored = np.ascontiguousarray(value, value.dtype.newbyteorder("<")).reshape(value.shape)
        if stored.dtype not in DTYPES:
            raise SnapshotError(f"a snapshot can't hold an array of {value.dtype}")
        numbers[id(value)] = len(arrays)
        arrays.append(stored)
    return numbers[id(value)]


def read_header(archive: zipfile.ZipFile) -> Any:
    """The snapshot's tree, its format and version checked."""
    names = [info.filename for info in archive.infolist()]
    if len(set(names)) != len(names) or HEADER not in names:
        raise SnapshotError("not a snapshot: it has no header, or members of the same name")
    if any(info.compress_type != zipfile.ZIP_STORED for info in archive.infolist()):
        raise SnapshotError("not a snapshot: its members are compressed")
    if sum(info.file_size for info in archive.infolist()) > archive.start_dir:
        raise SnapshotError("not a snapshot: its members overlap")
    header = json.loads(archive.read(HEADER).decode("utf-8"))
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise SnapshotError("not a snapshot of pt_engine")
    if header.get("version") != VERSION:
        raise SnapshotError(f"snapshot version {header.get('version')!r}; this program reads {VERSION}")
    return header["snapshot"]


class Members:
    """The arrays of an archive, each read once."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self.archive = archive
        self.arrays: dict[int, NDArray[Any]] = {}

    def array(self, number: int) -> NDArray[Any]:
        """Array `number`, owned and writable."""
        if type(number) is not int:
            raise SnapshotError("an array has no number")
        if number not in self.arrays:
            self.arrays[number] = read_npy(self.archive.read(f"{number}.npy"))
        return self.arrays[number]


def read_npy(content: bytes) -> NDArray[Any]:
    """An ``.npy`` file whose header tells the truth about its size."""
    stream = io.BytesIO(content)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise SnapshotError("an array of an unknown .npy version")
    shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
    count = math.prod(shape)
    if fortran or dtype not in DTYPES or min(shape, default=0) < 0:
        raise SnapshotError(f"an array of unexpected layout: {dtype}, {shape}")
    if count * dtype.itemsize != len(content) - stream.tell():
        raise SnapshotError("an array's length does not match its shape")
    native = dtype.newbyteorder("=")
    return np.frombuffer(content, dtype, count, stream.tell()).reshape(shape).astype(native)


def decode(tree: Any, members: Members) -> Any:
    """The value of a JSON tree."""
    if tree is None or isinstance(tree, str | bool | int | float):
        return tree
    if not isinstance(tree, dict) or len(tree) != 1:
        raise SnapshotError("malformed header")
    ((kind, content),) = tree.items()
    if kind == "array":
        return members.array(content)
    if kind == "tuple":
        return tuple(decode(item, members) for item in content)
    if kind == "dict":
        return {str(key): decode(item, members) for key, item in content}
    if kind == "link":
        node, socket = content
        return data.Link(node, socket)
    if kind == "float" and content in ("nan", "inf", "-inf"):
        return float(content)
    if kind not in CLASSES:
        raise SnapshotError(f"malformed header: {kind!r} is no part of a snapshot")
    return CLASSES[kind](**{name: decode(item, members) for name, item in content.items()})
