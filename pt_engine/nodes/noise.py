"""Fractals made of Perlin noise, value for value Blender's.

After Musgrave in Ebert et al., "Texturing and Modeling". A point is a list of 1 to 4 coordinate arrays (n,).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .hashes import floats_to_float
from .math_nodes import select
from .perlin import Cloud, Point, scaled_noise, signed_noise

Float32 = NDArray[np.float32]
MANY: Final = 8192  # lanes beside which what numpy's calls cost by themselves is little


def scaled(point: Point, s: Float32) -> list[Float32]:
    """point · s."""
    return [p * s for p in point]


def moved(point: Point, seed: float) -> list[Float32]:
    """The point shifted by the random offset number `seed`: 100 + 100·hash per axis."""
    if len(point) == 1:
        return [point[0] + _offset(seed)]
    return [p + _offset(seed, float(axis)) for axis, p in enumerate(point)]


@cache
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
        self.are_all_whole = not self.any_rest and bool((self.whole == self.last).all())

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
    for i, t in enumerate(scaled_noises(point, lacunarity, len(octaves.numbers))):
        t = np.multiply(t, amplitude, out=t if amplitude.size == 1 else None)
        if octaves.are_all_whole:
            total, reach = np.add(total, t, out=t), reach + amplitude
            amplitude = amplitude * roughness
            continue
        if octaves.any_rest:
            after, limit = total + t, reach + amplitude
            value, bound = _normalized(after, limit, normalize), _normalized(total, reach, normalize)
            r = octaves.rest
            partial = partial + octaves.is_next(i) * (r * (value - bound))
        on = octaves.has(i)
        total, reach = total + on * t, reach + on * amplitude
        amplitude = amplitude * roughness
    return _normalized(total, reach, normalize) + partial


def scaled_noises(point: Point, lacunarity: Float32, count: int) -> Iterator[Float32]:
    """Noise of the point times lacunarityⁱ, i < `count`; where lanes are few, of several i in one call."""
    cloud, scales = Cloud.of(point), [np.ones(1, np.float32)]
    for _ in range(count - 1):
        scales.append(scales[-1] * lacunarity)
    size = max(cloud.size, scales[-1].size)
    together = max(MANY // max(size, 1), 1)
    for first in range(0, count, together):
        some = scales[first : first + together]
        if some[-1].size == 1 and len(some) == 1:
            yield scaled_noise(cloud, some[0])
            continue
        wide = np.empty((len(point), len(some), size), np.float32)
        factors = np.stack(some if some[0].size == some[-1].size else np.broadcast_arrays(*some))
        for row, p in zip(wide, point, strict=True):
            np.multiply(p, factors, out=row)
        yield from signed_noise(wide.reshape(len(point), -1)).reshape(len(some), size)


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
