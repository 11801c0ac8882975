"""Object Info's Random of an object that isn't an instance: a hash of its name, the same as in Cycles.

`name_hash` is Blender's string hash (h = 37·h + c over its UTF-8 bytes), `jenkins` the final
mixing of Bob Jenkins' lookup3 (2006, public domain) over the pair (kx, 0).
"""

from __future__ import annotations

import numpy as np

MASK = 0xFFFFFFFF
SCALE = 1.0 / MASK
START = (0xDEADBEEF + (2 << 2) + 13) & MASK


def random_of(random_id, names, is_instance):
    """(I,) float32 in [0, 1]: from Blender's id for instances, from the name for the others."""
    ids = random_id.view(np.uint32).copy()
    known: dict[str, int] = {}
    for row in np.flatnonzero(~is_instance):
        name = names[row]
        if name not in known:
            known[name] = jenkins(name_hash(name))
        ids[row] = known[name]
    return (ids * SCALE).astype(np.float32)


def name_hash(name: str) -> int:
    """32-bit hash of a name."""
    result = 0
    for byte in name.encode():
        result = (result * 37 + byte) & MASK
    return result


def jenkins(kx: int) -> int:
    """Hash of (kx, 0)."""
    a, b, c = (START + kx) & MASK, START, START
    c = ((c ^ b) - rotated(b, 14)) & MASK
    a = ((a ^ c) - rotated(c, 11)) & MASK
    b = ((b ^ a) - rotated(a, 25)) & MASK
    c = ((c ^ b) - rotated(b, 16)) & MASK
    a = ((a ^ c) - rotated(c, 4)) & MASK
    b = ((b ^ a) - rotated(a, 14)) & MASK
    return ((c ^ b) - rotated(b, 24)) & MASK


def rotated(x: int, bits: int) -> int:
    """32-bit rotation to the left."""
    return ((x << bits) | (x >> (32 - bits))) & MASK
