"""Which files an image stands for: a path, a frame of a sequence, the tiles of a UDIM."""

from __future__ import annotations

import re

import bpy

FIRST_TILE = 1001


def absolute(path: str, image) -> str:
    """A path of an image, relative ones from the .blend or the library that holds it."""
    return bpy.path.abspath(path, library=image.library) if path else ""


def file_path(image, user=None, frame: int = 1) -> str:
    """Absolute path of the image's file; of a sequence, the file at the scene's `frame`."""
    path = image.filepath
    if image.source == "SEQUENCE" and user is not None and path:
        path = sequence_file(path, sequence_frame(user, frame))
    return absolute(path, image)


def sequence_frame(user, frame: int) -> int:
    """Number of the file that an image user shows at a frame of the scene.

    The settings count: Start Frame, Frames, Offset and Cyclic. Auto Refresh does not: Cycles looks anew in
    each render. Before the start it is number 0, of which there often is no file.
    """
    length = user.frame_duration
    if length == 0:
        return 0
    position = frame - user.frame_start + 1
    if user.use_cyclic:
        position = (position - 1) % length + 1
    return min(max(position, 0), length) + user.frame_offset


def sequence_file(path: str, number: int) -> str:
    """The path with its last group of digits replaced by a number of the same width."""
    folder, name = re.fullmatch(r"(.*[/\\])?(.*)", path, re.DOTALL).groups()
    stem, dot, suffix = name.rpartition(".") if "." in name else (name, "", "")
    found = re.fullmatch(r"(.*?)(\d+)(\D*)", stem, re.DOTALL)
    head, digits, tail = found.groups() if found else (stem, "", "")
    width = len(digits)
    return f"{folder or ''}{head}{number:0{width}d}{tail}{dot}{suffix}"


def tile_path(image, number: int) -> str:
    """Absolute path of a UDIM tile's file: both of Blender's tokens stand for the tile."""
    column, row = (number - FIRST_TILE) % 10, (number - FIRST_TILE) // 10
    path = image.filepath.replace("<UDIM>", f"{number:04d}")
    return absolute(path.replace("<UVTILE>", f"u{column + 1}_v{row + 1}"), image)
