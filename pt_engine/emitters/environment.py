"""The world as an emitter: a constant, or an image of its brightness to draw directions from.

Blender's equirectangular convention (kernel/camera/projection.h of Cycles): with u to the right and v up,

    φ = atan2(y, x) = π − 2π u          θ = acos z = π (1 − v)

The density is constant per solid angle within each texel, so a direction is uniform in φ and in z there
and the density is a plain look-up, without a pole to divide by.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Protocol

import numpy as np

from ..core.distributions import Distribution2D
from .base import Float32, Float64

TWO_PI = float(2.0 * np.pi)
UNIFORM = float(1.0 / (4.0 * np.pi))
Radiance = Callable[[Float32], Float32]  # directions (3, N) -> (3, N)


class Environment(Protocol):
    """What Lights asks of an environment; densities do not know of other emitters."""

    constant: Float64 | None  # (3,) radiance if it is the same everywhere
    irradiance: float  # ∫ L dω, W·m⁻²: its flux through a cross-section

    def radiance(self, d: Float32) -> Float32: ...
    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]: ...
    def pdf(self, d: Float32) -> Float32: ...
    @property
    def compensated(self) -> Environment: ...


class ConstantEnvironment:
    """The same radiance everywhere, sampled uniformly."""

    def __init__(self, radiance: tuple[float, float, float]) -> None:
        self.constant: Float64 | None = np.asarray(radiance, np.float64)
        self.irradiance = float(4.0 * np.pi * np.abs(self.constant).mean())
        self._radiance = self.constant.astype(np.float32)[:, None]

    def radiance(self, d: Float32) -> Float32:
        """(3, N)."""
        return np.repeat(self._radiance, d.shape[1], axis=1)

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        """Uniform directions (3, n) and their density (n,)."""
        z = 1.0 - 2.0 * u
        sin, phi = np.sqrt(4.0 * u * (1.0 - u)), TWO_PI * v
        d = np.empty((3, u.size), np.float32)
        d[0], d[1], d[2] = sin * np.cos(phi), sin * np.sin(phi), z
        return d, np.full(u.shape, UNIFORM, np.float32)

    def pdf(self, d: Float32) -> Float32:
        """(n,) density of `sample`."""
        return np.full(d.shape[1], UNIFORM, np.float32)

    @property
    def compensated(self) -> ConstantEnvironment:
        """Itself: nothing is brighter than the rest, so that `Lights` leaves it to BSDF samples."""
        return self


def texel_directions(height: int, width: int) -> Float32:
    """(3, height · width) unit directions of texel centres, bottom row first: where to evaluate the image."""
    v, u = np.divmod(np.arange(height * width), width)
    theta, phi = np.pi * (1.0 - (v + 0.5) / height), np.pi * (1.0 - 2.0 * (u + 0.5) / width)
    sin = np.sin(theta)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)]).astype(np.float32)


def bilinear_means(image: Float64) -> Float64:
    """(H, W) mean over each texel of the image's bilinear interpolation: [1 6 1] / 8 along both axes.

    What is looked up between a bright texel and a black one is not black: the density must not be either.
    """
    rows = np.pad(image, ((1, 1), (0, 0)), mode="edge")
    image = (rows[:-2] + 6.0 * image + rows[2:]) / 8.0
    return np.asarray((np.roll(image, 1, axis=1) + 6.0 * image + np.roll(image, -1, axis=1)) / 8.0)


class EnvironmentMap:
    """Directions drawn in proportion to an image of the world's brightness.

    Parameters
    ----------
    image : (H, W) float
        Brightness at texel centres (`texel_directions`), bottom row first. Negative and non-finite
        values count as 0; an all-black image is sampled uniformly.
    radiance : callable
        Le of directions (3, N), as rays that miss see it.
    compensates : bool
        Whether only what is brighter than the mean is drawn: MIS compensation (Karlik et al. 2019). BSDF
        sampling finds the rest, so this is for estimators that combine both.
    """

    constant: Float64 | None = None

    def __init__(self, image: Float32 | Float64, radiance: Radiance, compensates: bool = False) -> None:
        bright = np.nan_to_num(np.asarray(image, np.float64), nan=0.0, posinf=0.0, neginf=0.0)
        bright = bilinear_means(np.maximum(bright, 0.0))
        height, width = bright.shape
        edges = -np.cos(np.pi * np.arange(height + 1) / height)
        thickness = np.diff(edges)
        solid = TWO_PI / width * thickness
        if not bright.any():
            bright = np.ones_like(bright)
        flux = bright * solid[:, None]
        self.irradiance = float(flux.sum())
        self._image, self._flux = image, flux
        if compensates:
            mean = self.irradiance / (4 * np.pi)
            excess = np.maximum(bright - mean, 0.0) * solid[:, None]
            self._flux = excess if excess.any() else flux
        self._radiance = radiance
        self._height = height
        self._bottom, self._thickness = edges[:-1].astype(np.float32), thickness.astype(np.float32)
        self._per_solid_angle = (1.0 / (height * width * solid)).astype(np.float32)

    @cached_property
    def _square(self) -> Distribution2D:
        """Made when it is asked for: a scene whose integrator compensates has no use for the other."""
        return Distribution2D(self._flux)

    @cached_property
    def compensated(self) -> EnvironmentMap:
        """The same light, drawn for estimators that combine it with BSDF sampling."""
        return EnvironmentMap(self._image, self._radiance, compensates=True)

    def radiance(self, d: Float32) -> Float32:
        """(3, N)."""
        return self._radiance(d)

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        """Directions (3, n) and their density (n,)."""
        x, y, density = self._square.sample(u, v)
        y *= self._height
        line = y.astype(np.int32)
        y -= line
        y *= self._thickness.take(line, mode="clip")
        y += self._bottom.take(line, mode="clip")
        density *= self._per_solid_angle.take(line, mode="clip")
        sin = np.sqrt(np.maximum((1.0 - y) * (1.0 + y), 0.0))
        phi = float(np.pi) - TWO_PI * x
        d = np.empty((3, u.size), np.float32)
        d[0], d[1], d[2] = sin * np.cos(phi), sin * np.sin(phi), y
        return d, density

    def pdf(self, d: Float32) -> Float32:
        """(n,) density of `sample`."""
        x = 0.5 - np.arctan2(d[1], d[0]) * (1.0 / TWO_PI)
        y = 1.0 - np.arccos(np.clip(d[2], -1.0, 1.0)) * (2.0 / TWO_PI)
        line = (y * self._height).astype(np.int32)
        density: Float32 = self._square.pdf(x, y) * self._per_solid_angle.take(line, mode="clip")
        return density
