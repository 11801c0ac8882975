"""One unit of work: camera rays, the integrator's estimate, and what it cost."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cameras.base import Camera
from ..core.pixel_filters import FilterTable
from ..core.samplers import Sampler
from ..scene.scene import Scene
from ..scene.wave import Rays
from .dimensions import LaneSampler
from .integrator import Integrator
from .schedule import Unit
from .settings import RenderSettings

Float32 = NDArray[np.float32]


class UnitResult(NamedTuple):
    """Radiance (3, N) and coverage (N,) of a unit, sample-major: slot = sample · pixels + pixel."""

    unit: Unit
    radiance: Float32
    alpha: Float32 | None
    rays: dict[str, int]


class Worker:
    """Renders units; holds nothing that changes, so threads may share one.

    Parameters
    ----------
    scene : Scene
    settings : RenderSettings
    integrator : Integrator
    sampler : Sampler

    Attributes
    ----------
    scene : Scene
        As the integrator sees it.
    """

    def __init__(
        self, scene: Scene, settings: RenderSettings, integrator: Integrator, sampler: Sampler
    ) -> None:
        if integrator.combines:
            scene = scene.with_compensated_lights()
        self.scene = scene.with_pixels(settings.width, settings.height)
        self._settings = settings
        self._integrator, self._sampler = integrator, sampler
        self._filter = FilterTable(settings.pixel_filter, settings.filter_width)
        self._camera: Camera = scene.camera.at_resolution(settings.width, settings.height)

    def render(self, unit: Unit) -> UnitResult:
        """Estimate the radiance of each of the unit's camera rays."""
        sampler = self.lane_sampler(unit)
        rays = self.camera_rays(unit, sampler)
        scene = self.scene.for_unit(rays.o.shape[1])
        radiance = self.exposed(self._integrator.sample(scene, rays, sampler))
        return UnitResult(unit, radiance, scene.alpha, scene.rays)

    def exposed(self, radiance: Float32) -> Float32:
        """What the film takes of a radiance (3, N): all of it unless the file sets a film exposure."""
        return radiance if self.scene.exposure == 1 else radiance * np.float32(self.scene.exposure)

    def lane_sampler(self, unit: Unit) -> LaneSampler:
        """Random numbers by (pixel of the full image, sample)."""
        x, y = self._pixel_coordinates(unit)
        pixel = (y * self._settings.width + x).astype(np.uint32)
        sample = np.arange(unit.first, unit.first + unit.spp, dtype=np.uint32)
        state = self._sampler.state(np.tile(pixel, unit.spp), np.repeat(sample, len(pixel)))
        return LaneSampler(self._sampler, state)

    def camera_rays(self, unit: Unit, sampler: LaneSampler) -> Rays:
        """One ray per lane through a point drawn from the pixel filter and, with a lens, a point on it."""
        x, y = self._pixel_coordinates(unit)
        offset = self._filter.sample(sampler.pixel())
        raster = np.stack([np.tile(c, unit.spp) for c in (x, y)]).astype(np.float32)
        raster += np.float32(0.5)
        raster += offset
        return Rays(*self._camera.rays(raster, sampler.lens() if self._camera.has_lens else None))

    def _pixel_coordinates(self, unit: Unit) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        x0, y0, x1, _ = self._settings.window
        y, x = np.divmod(unit.pixels.astype(np.int64), x1 - x0)
        return x + x0, y + y0
