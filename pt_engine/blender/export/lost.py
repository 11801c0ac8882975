"""Linked data that is not there: Blender puts placeholders in its place."""

from __future__ import annotations

NOT_THERE = "not in its library"


def lost(depsgraph):
    """What is not in its library, or whose library is gone; of images it is said where they are read."""
    for block in depsgraph.ids:
        original = block.original
        if original.is_missing and original.id_type != "IMAGE":
            where = f"{original.rna_type.name} {original.name}"
            yield (where, NOT_THERE, f"Blender's placeholder, which is empty{in_place_of(original)}")


def in_place_of(block) -> str:
    """The library that does not bring it."""
    return f", in place of what {block.library.filepath} had" if block.library else ""
