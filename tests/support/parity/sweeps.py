"""What the nodes are fed: ordinary values of each input's range, then hostile and extreme ones."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Table = dict[str, Float32]

SIDE = 16  # faces along a sheet
FACES = SIDE * SIDE
ORDINARY = slice(0, 128)  # faces with ordinary values
HOSTILE = slice(128, 224)  # every other value hostile, but within the input's `limits`
EXTREME = slice(224, 256)  # every other value hostile, however large
JITTER = 4  # units in the last place by which an input may be moved
TRIES = 24

# Zero, ones, halves and integers with their neighbours, angles, the small, the huge. No subnormal numbers:
# Cycles sets the processor to take them for 0. No −0: attributes lose its sign on the way into Cycles.
ODD = np.array(
    [
        *(0.0, 0.0, 0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, 3.0, -7.0, 100.0, 255.0),
        *(np.nextafter(np.float32(x), np.float32(y)) for x in (1, -1, 3) for y in (-9, 9)),
        *(np.pi, np.pi / 2, -np.pi, 1e-3, 1e-6, -1e-6, 1e-20, -1e-20, 1e-30),
        *(1e3, -1e3, 1e6, -1e6, 16777216.0, 1e10, 1e20, -1e20),
    ],
    np.float32,
)


class Feed(NamedTuple):
    """An attribute that feeds an input: bounds of its ordinary values, limits of its hostile ones."""

    name: str
    bounds: tuple[float, float]
    limits: tuple[float, float]


def sweep(name: str, fed: Iterable[Feed]) -> Table:
    """Attribute → (3, FACES) values.

    Parameters
    ----------
    name : str
        Of the case: its numbers are its own whatever other cases there are.
    """
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    table = {}
    for key, (low, high), limits in fed:
        values = rng.uniform(low, high, (3, FACES)).astype(np.float32)
        plain = np.array([x for x in (0, 1, -1, 0.5, 2) if low <= x <= high] or [low], np.float32)
        values[:, 3:128:9] = rng.choice(plain, values[:, 3:128:9].shape)
        for part, pool in ((HOSTILE, np.clip(ODD, *limits)), (EXTREME, ODD)):
            some = rng.random(values[:, part].shape) < 0.5
            values[:, part] = np.where(some, rng.choice(pool, some.shape), values[:, part])
        table[key] = values
    return table


def jittered(table: Table, faces: NDArray[np.intp]) -> Table:
    """(3, TRIES · faces) the inputs of some faces, moved by up to `JITTER` units in the last place.

    A result that lies between those of inputs so near is right as far as float32 can tell: at a jump, on
    the border of a cell, where digits cancel.
    """
    rng = np.random.default_rng(len(faces))
    moved = {}
    for key, values in table.items():
        some = np.repeat(values[:, faces], TRIES, axis=1)
        steps = rng.integers(-JITTER, JITTER + 1, some.shape)
        moved[key] = (some + steps * np.spacing(some)).astype(np.float32)
    return moved
