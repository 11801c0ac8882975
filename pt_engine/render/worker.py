"""One unit of work: camera rays, the integrator's estimate, and what it cost."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cameras.base import Camera
from ..core.pixel_filters import FilterTable
from ..core.raykind import RayKind
from ..core.samplers import Sampler
from ..scene.scene import Scene
from ..scene.wave import Rays
from .catcher_film import Parts
from .dimensions import LaneSampler
from .integrator import Integrator
from .schedule import Unit
from .settings import RenderSettings

Float32 = NDArray[np.float32]


class UnitResult(NamedTuple):
    """Radiance (3, N) and coverage (N,) of a unit, sample-major: slot = sample · pixels + pixel.

    `caught` are the parts of it where there are shadow catchers.
    """

    unit: Unit
    radiance: Float32
    alpha: Float32 | None
    rays: dict[str, int]
    caught: Parts | None = None


class Worker:
    """Renders units; holds nothing that changes, so threads may share one.

    Parameters
    ----------
    scene : Scene
    settings : RenderSettings
    integrator : Integrator
    sampler : Sampler
    """

    def __init__(
        self, scene: Scene, settings: RenderSettings, integrator: Integrator, sampler: Sampler
    ) -> None:
        self._scene = scene.with_pixels(settings.width, settings.height)
        self._alone = scene.alone.with_pixels(settings.width, settings.height) if scene.alone else None
        self._settings = settings
        self._integrator, self._sampler = integrator, sampler
        self._filter = FilterTable(settings.pixel_filter, settings.filter_width)
        self._camera: Camera = scene.camera.at_resolution(settings.width, settings.height)

    def render(self, unit: Unit) -> UnitResult:
        """Estimate the radiance of each of the unit's camera rays."""
        sampler = self.lane_sampler(unit)
        rays = self.camera_rays(unit, sampler)
        scene = self._scene.for_unit(rays.o.shape[1])
        radiance = self.exposed(self._integrator.sample(scene, rays, sampler))
        if scene.caught is None or self._alone is None:
            return UnitResult(unit, radiance, scene.alpha, scene.rays)
        return UnitResult(unit, radiance, scene.alpha, scene.rays, self.parts(unit, scene, radiance))

    def parts(self, unit: Unit, scene: Scene, radiance: Float32) -> Parts:
        """The light that catchers send in the whole scene and alone, by the same random numbers."""
        sampler, caught = self.lane_sampler(unit), scene.caught
        rays = self.camera_rays(unit, sampler)
        assert caught is not None
        assert self._alone is not None
        rays.tfar[~caught.hit] = -1
        alone = self._alone.for_unit(rays.o.shape[1])
        light = self._integrator.sample(alone, rays, sampler)
        assert alone.caught is not None
        scene.rays.update(alone.rays)
        matte = np.where(caught.hit, self.exposed(caught.light), radiance)
        return Parts(
            matte=matte,
            matte_alpha=np.where(caught.hit, caught.alpha, scene.alpha),
            shaded=radiance - matte,
            alone=self.exposed((light - alone.caught.light) * caught.beta) * caught.hit,
            hit=caught.hit.astype(np.float32),
            sky=None if scene.film_transparent else self.exposed(caught.sky),
        )

    def exposed(self, radiance: Float32) -> Float32:
        """What the film takes of a radiance (3, N): all of it unless the file sets a film exposure."""
        return radiance if self._scene.exposure == 1 else radiance * np.float32(self._scene.exposure)

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
        o, d, tfar = self._camera.rays(raster, sampler.lens() if self._camera.has_lens else None)
        return Rays(o, d, tfar, RayKind.CAMERA)

    def _pixel_coordinates(self, unit: Unit) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        x0, y0, x1, _ = self._settings.window
        y, x = np.divmod(unit.pixels.astype(np.int64), x1 - x0)
        return x + x0, y + y0
