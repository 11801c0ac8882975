"""Perlin noise in 1 to 4 dimensions and the fractals made of it, value for value Blender's.

Perlin 2002, "Improving Noise", with Jenkins' hash for the lattice; fractals after Musgrave in Ebert et al.,
"Texturing and Modeling". A point is a list of 1 to 4 coordinate arrays (n,).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .hashes import floats_to_float, hash_uints
from .math_nodes import select

Float32 = NDArray[np.float32]
Point = Sequence[Float32]

SCALE: Final = (0.25, 0.6616, 0.9820, 0.8344)  # to about [-1, 1], by dimension
PERIOD: Final = np.float32(100000)
BLOCK = 4096  # lanes at a time: all corners of a block stay in cache


def _gradients(dimension: int) -> Float32:
    """(dimension, K) gradient of each hash value's low bits."""
    size = {1: 16, 2: 8, 3: 16, 4: 32}[dimension]
    table = np.zeros((dimension, size), np.float32)
    for h in range(size):
        if dimension == 1:
            table[0, h] = (1 + (h & 7)) * (-1 if h & 8 else 1)
            continue
        if dimension == 2:
            axes: tuple[int, ...] = (0, 1) if h < 4 else (1, 0)
            factors: tuple[float, ...] = (1, 2)
        elif dimension == 3:
            axes = (0 if h < 8 else 1, 1 if h < 4 else 0 if h in (12, 14) else 2)
            factors = (1, 1)
        else:
            axes = (0 if h < 24 else 1, 1 if h < 16 else 2, 2 if h < 8 else 3)
            factors = (1, 1, 1)
        for bit, (axis, factor) in enumerate(zip(axes, factors, strict=True)):
            table[axis, h] += -factor if h >> bit & 1 else factor
    return table


GRADIENTS: Final = {d: _gradients(d) for d in (1, 2, 3, 4)}


def _fade(t: Float32) -> Float32:
    return t * t * t * (t * (t * 6 - 15) + 10)


def _perlin_block(point: Point) -> Float32:
    """Unscaled noise of one block.

    Every axis has an array dimension of its own for the two corners, the first axis the innermost, so
    that what corners have in common is computed once by broadcasting.
    """
    dimension = len(point)
    keys, offsets, parts = [], [], []
    for axis, p in enumerate(point):
        low = np.floor(p)
        part = p - low
        shape = [1] * dimension + [-1]
        shape[dimension - 1 - axis] = 2
        cell = low.astype(np.int32).view(np.uint32)
        keys.append(np.stack([cell, cell + np.uint32(1)]).reshape(shape))
        offsets.append(np.stack([part, part - np.float32(1)]).reshape(shape))
        parts.append(part)
    table = GRADIENTS[dimension]
    h = hash_uints(*keys)
    h &= np.uint32(table.shape[1] - 1)
    index = h.view(np.int32)
    values = table[0].take(index)
    values *= offsets[0]
    for axis in range(1, dimension):
        slope = table[axis].take(index)
        slope *= offsets[axis]
        values += slope
    for part in parts:
        low, high = values[..., 0, :], values[..., 1, :]
        values = low + _fade(part) * (high - low)
    out: Float32 = values
    return out


def signed_noise(point: Point) -> Float32:
    """Perlin noise in about [−1, 1]; it repeats every 100000 units, as in Blender."""
    size = max(p.shape[-1] for p in point)
    out = np.empty(size, np.float32)
    wide = [np.broadcast_to(p, size) for p in point]
    for start in range(0, size, BLOCK):
        block = [_periodic(p[start : start + BLOCK]) for p in wide]
        out[start : start + BLOCK] = _perlin_block(block)
    out *= np.float32(SCALE[len(point) - 1])
    return out


def _periodic(p: Float32) -> Float32:
    """Into (−100000, 100000); half a step off where the number is too coarse for the lattice."""
    far = np.abs(p) >= np.float32(1000000)
    if far.any() or (np.abs(p) >= PERIOD).any():
        p = np.fmod(p, PERIOD) + np.float32(0.5) * far
    return np.nan_to_num(p, nan=0.0, posinf=0.0, neginf=0.0) if not np.isfinite(p).all() else p


def scaled(point: Point, s: Float32) -> list[Float32]:
    """point · s."""
    return [p * s for p in point]


def moved(point: Point, seed: float) -> list[Float32]:
    """The point shifted by the random offset number `seed`: 100 + 100·hash per axis."""
    if len(point) == 1:
        return [point[0] + _offset(seed)]
    return [p + _offset(seed, float(axis)) for axis, p in enumerate(point)]


def _offset(*seeds: float) -> Float32:
    """100 + 100·hash, rounded once."""
    return (100 + floats_to_float(*seeds).astype(np.float64) * 100).astype(np.float32)


# ------------------------------------------------------------------ fractals


class Octaves:
    """Which octaves a detail setting has: whole ones, and a fraction of one more, per lane."""

    def __init__(self, detail: Float32) -> None:
        self.detail = np.clip(detail, 0, 15)
        self.whole = np.floor(self.detail)
        self.rest = self.detail - self.whole
        self.last = int(self.whole.max(initial=0))
        self.any_rest = bool((self.rest != 0).any())

    def has(self, i: int) -> Float32:
        """1 where octave i is a whole one."""
        return np.float32(1) * np.atleast_1d(self.whole >= i)

    def is_next(self, i: int) -> Float32:
        """1 where octave i is the first that is not."""
        out: Float32 = np.float32(1) * np.atleast_1d(self.whole + 1 == i)
        return out

    @property
    def numbers(self) -> range:
        """All octaves that some lane needs."""
        return range(self.last + (2 if self.any_rest else 1))


def fbm(point: Point, detail: Float32, roughness: Float32, lacunarity: Float32, normalize: bool) -> Float32:
    """Fractal Brownian motion: octaves added with amplitudes roughnessⁱ."""
    octaves = Octaves(detail)
    amplitude = np.ones(1, np.float32)
    total, reach = np.zeros(1, np.float32), np.zeros(1, np.float32)
    partial = np.zeros(1, np.float32)
    scale = np.ones(1, np.float32)
    for i in octaves.numbers:
        t = signed_noise(scaled(point, scale)) * amplitude
        if octaves.any_rest:
            after, limit = total + t, reach + amplitude
            value, bound = _normalized(after, limit, normalize), _normalized(total, reach, normalize)
            r = octaves.rest
            partial = partial + octaves.is_next(i) * (r * (value - bound))
        on = octaves.has(i)
        total, reach = total + on * t, reach + on * amplitude
        amplitude, scale = amplitude * roughness, scale * lacunarity
    return _normalized(total, reach, normalize) + partial


def _normalized(total: Float32, reach: Float32, normalize: bool) -> Float32:
    if not normalize:
        return total
    out: Float32 = np.float32(0.5) * total / (reach + (reach == 0)) + np.float32(0.5)
    return out


def multifractal(point: Point, detail: Float32, roughness: Float32, lacunarity: Float32) -> Float32:
    """Octaves multiplied."""
    octaves = Octaves(detail)
    value, power = np.ones(1, np.float32), np.ones(1, np.float32)
    p = list(point)
    for i in octaves.numbers:
        step = power * signed_noise(p)
        value = value * (1 + (octaves.has(i) + octaves.is_next(i) * octaves.rest) * step)
        power, p = power * roughness, scaled(p, lacunarity)
    return value


def hetero_terrain(
    point: Point, detail: Float32, roughness: Float32, lacunarity: Float32, offset: Float32
) -> Float32:
    """Octaves scaled by the height so far."""
    octaves = Octaves(detail)
    power = roughness
    value = offset + signed_noise(point)
    p = scaled(point, lacunarity)
    for i in octaves.numbers[1:]:
        step = (signed_noise(p) + offset) * power * value
        value = value + (octaves.has(i) + octaves.is_next(i) * octaves.rest) * step
        power, p = power * roughness, scaled(p, lacunarity)
    return value


def hybrid_multifractal(
    point: Point,
    detail: Float32,
    roughness: Float32,
    lacunarity: Float32,
    offset: Float32,
    gain: Float32,
) -> Float32:
    """Octaves weighted by the signal so far, until the weight falls below 0.001."""
    octaves = Octaves(detail)
    power, weight = np.ones(1, np.float32), np.ones(1, np.float32)
    value = np.zeros(1, np.float32)
    p = list(point)
    for i in octaves.numbers:
        alive = weight > np.float32(0.001)
        w = np.minimum(weight, 1)
        signal = (signed_noise(p) + offset) * power
        share = octaves.has(i) + octaves.is_next(i) * octaves.rest
        value = value + select(alive, share * w * signal, np.float32(0))
        weight = select(alive, w * gain * signal, weight)
        power, p = power * roughness, scaled(p, lacunarity)
    return value


def ridged_multifractal(
    point: Point,
    detail: Float32,
    roughness: Float32,
    lacunarity: Float32,
    offset: Float32,
    gain: Float32,
) -> Float32:
    """Octaves of (offset − |noise|)², weighted by the one before; a fraction of an octave is dropped."""
    octaves = Octaves(detail)
    power = roughness
    signal = (offset - np.abs(signed_noise(point))) ** 2
    value = signal
    p = list(point)
    for i in range(1, octaves.last + 1):
        p = scaled(p, lacunarity)
        weight = np.clip(signal * gain, 0, 1)
        signal = (offset - np.abs(signed_noise(p))) ** 2 * weight
        value = value + octaves.has(i) * (signal * power)
        power = power * roughness
    return value


Fractal = Callable[[Point, Sequence[Float32], bool], Float32]
# settings: detail, roughness, lacunarity, offset, gain
FRACTALS: Final[dict[str, Fractal]] = {
    "FBM": lambda p, s, normalize: fbm(p, s[0], s[1], s[2], normalize),
    "MULTIFRACTAL": lambda p, s, _: multifractal(p, *s[:3]),
    "HETERO_TERRAIN": lambda p, s, _: hetero_terrain(p, *s[:4]),
    "HYBRID_MULTIFRACTAL": lambda p, s, _: hybrid_multifractal(p, *s),
    "RIDGED_MULTIFRACTAL": lambda p, s, _: ridged_multifractal(p, *s),
}
