"""The Gabor Texture: sparse convolution of Gabor kernels, with phase and intensity of the sum.

Each cell of a unit grid throws eight impulses of weight ±1 (Tavernier et al. 2019, "Making Gabor Noise Fast
and Normalized": a fixed number, Bernoulli weights). An impulse is a phasor (Tricard et al. 2019,
"Procedural Phasor Noise"),

    k(x) = w(|x|²) e^(2πi f·x),      w(r²) = e^(−πr²) (½ + ½ cos πr²),  0 beyond r = 1,

with a frequency f in one direction (anisotropic) or in a random one each.
"""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from . import hashes
from .coordinates import coordinates
from .graph import NodeView
from .ir import FLOAT, op
from .math_nodes import select
from .registry import Outputs, node
from .vector_nodes import unit

Float32 = NDArray[np.float32]
IMPULSES: Final = 8
PI: Final = np.float32(np.pi)
# six standard deviations: √(impulses · ½ · ∫k²), with the limit of the integral at high frequencies
SPREAD: Final[dict[int, np.float32]] = {
    2: np.float32(6 * np.sqrt(IMPULSES * 0.5 * 0.25)),
    3: np.float32(6 * np.sqrt(IMPULSES * 0.5 / (4 * np.sqrt(2.0)))),
}


def phasors(point: list[Float32], frequency: Float32, isotropy: Float32, turn: Float32) -> list[Float32]:
    """Real and imaginary part of the noise at a point of 2 or 3 coordinates.

    `turn` is the base orientation: an angle (n,) in 2D, a unit vector (3, n) in 3D.
    """
    cells = [np.floor(p) for p in point]
    local = [p - c for p, c in zip(point, cells, strict=True)]
    total = [np.zeros(1, np.float32), np.zeros(1, np.float32)]
    for offset in itertools.product((-1, 0, 1), repeat=len(point)):
        cell = [c + np.float32(o) for c, o in zip(cells, offset[::-1], strict=True)]
        place = [x - np.float32(o) for x, o in zip(local, offset[::-1], strict=True)]
        for k in range(IMPULSES):
            real, imaginary = impulse(cell, place, k, frequency, isotropy, turn)
            total = [total[0] + real, total[1] + imaginary]
    return total


def impulse(
    cell: list[Float32], place: list[Float32], k: int, frequency: Float32, isotropy: Float32, turn: Float32
) -> tuple[Float32, Float32]:
    """The phasor of impulse number k of a cell at a place relative to the cell's corner."""
    center = centers(cell, 3.0 * k + 1)
    x = [p - c for p, c in zip(place, center, strict=True)]
    squared = sum((c * c for c in x), np.float32(0))
    window = np.exp(-PI * squared) * (np.float32(0.5) + np.float32(0.5) * np.cos(PI * squared))
    sign = select(hashes.floats_to_float(*cell, 3.0 * k + 2) < 0.5, -1, 1)
    window = window * sign * (squared < 1)
    wave = direction(cell, 3.0 * k, isotropy, turn)
    along = sum((a * (frequency * b) for a, b in zip(x, wave, strict=True)), np.float32(0))
    angle = 2 * PI * along
    return window * np.cos(angle), window * np.sin(angle)


def centers(cell: list[Float32], seed: float) -> list[Float32]:
    """A random point of a cell."""
    if len(cell) == 3:
        return list(hashes.floats_to_color(*cell, np.full(1, seed, np.float32)))
    x, y = cell
    return [hashes.floats_to_float(x, y, seed), hashes.floats_to_float(seed, x, y)]


def direction(cell: list[Float32], seed: float, isotropy: Float32, turn: Float32) -> list[Float32]:
    """Unit direction of an impulse's frequency: the base orientation, turned at random by the isotropy.

    An orientation along z has no azimuth: a quarter turn is taken, where Cycles' texture turns black.
    """
    if len(cell) == 2:
        angle = turn + (hashes.floats_to_float(*cell, seed) - np.float32(0.5)) * PI * isotropy
        return [np.cos(angle), np.sin(angle)]
    if not (isotropy != 0).any():
        return list(turn)
    x, y, z = cell
    flat = np.sqrt(turn[0] * turn[0] + turn[1] * turn[1])
    azimuth = np.arccos(np.clip(turn[0] / (flat + (flat == 0)), -1, 1)) * select(turn[1] < 0, -1, 1)
    azimuth = azimuth + hashes.floats_to_float(z, x, seed, y) * PI * isotropy
    inclination = np.arccos(np.clip(turn[2], -1, 1)) + hashes.floats_to_float(x, y, z, seed) * PI * isotropy
    sine = np.sin(inclination)
    return [sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(inclination)]


@op(FLOAT, FLOAT, FLOAT, dear=True)
def gabor(
    dimensions: int,
    vector: Float32,
    scale: Float32,
    frequency: Float32,
    anisotropy: Float32,
    flat: Float32,
    solid: Float32,
) -> tuple[Float32, Float32, Float32]:
    """Value, phase and intensity."""
    point = [vector[k] * scale for k in range(dimensions)]
    isotropy = 1 - np.clip(anisotropy, 0, 1)
    turn = flat if dimensions == 2 else unit(solid)
    real, imaginary = phasors(point, np.maximum(frequency, np.float32(1e-3)), isotropy, turn)
    spread = SPREAD[dimensions]
    value: Float32 = imaginary / spread * np.float32(0.5) + np.float32(0.5)
    phase: Float32 = (np.arctan2(imaginary, real) + PI) / (2 * PI)
    size: Float32 = np.sqrt(real * real + imaginary * imaginary)
    return value, phase, size / spread


@node("TexGabor")
def tex_gabor(n: NodeView) -> Outputs:
    inputs = (
        coordinates(n),
        n.float("Scale", 5.0),
        n.float("Frequency", 2.0),
        n.float("Anisotropy", 1.0),
        n.float("Orientation 2D", np.pi / 4),
        n.vector("Orientation 3D", (np.sqrt(2.0), np.sqrt(2.0), 0.0)),
    )
    out = n.calls(gabor, *inputs, static=(int(str(n.prop("gabor_type", "2D"))[0]),))
    return dict(zip(("Value", "Phase", "Intensity"), out, strict=True))
