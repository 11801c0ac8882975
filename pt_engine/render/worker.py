"""One unit of work: camera rays, the integrator's estimate, and what it cost."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cameras.base import Camera
from ..core.clock import new_paths, stage, unit_of_work
from ..core.pixel_filters import FilterTable
from ..core.raykind import RayKind
from ..core.samplers import Sampler
from ..scene.scene import Scene
from ..scene.wave import Rays
from .catcher_film import Parts, empty_parts, flattened, put
from .dimensions import LaneSampler
from .integrator import Integrator
from .moments import Moments, Part
from .schedule import Unit
from .settings import RenderSettings

Float32 = NDArray[np.float32]


class UnitResult(NamedTuple):
    """Radiance (3, N) and coverage (N,) of a unit, sample-major: slot = sample · pixels + pixel.

    `caught` are the parts of it where there are shadow catchers, `by_group` (3, G + 1, N) its shares where
    there are light groups; `seconds` is how long it took.
    """

    unit: Unit
    radiance: Float32
    alpha: Float32 | None
    rays: dict[str, int]
    caught: Parts | None = None
    by_group: Float32 | None = None
    seconds: float = 0.0


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
        self._settings = settings
        self._integrator, self._sampler = integrator, sampler
        self.scene = self.seen(scene)
        self._filter = FilterTable(settings.pixel_filter, settings.filter_width)
        self.moments = Moments(scene.slices, settings, sampler, self.seen) if scene.slices else None

    def seen(self, scene: Scene) -> Scene:
        """A scene as this integrator sees it at this image's size."""
        if self._integrator.combines:
            scene = scene.with_compensated_lights()
        scene = scene.with_pixels(self._settings.width, self._settings.height)
        if scene.alone is not None:
            scene.alone = self.seen(scene.alone)
        return scene

    @property
    def run(self) -> int:
        """Samples of a pixel, from a multiple of it on, that are best rendered together; 0 for any."""
        return 0 if self.moments is None else self.moments.block

    def groups(self, order: NDArray[np.int32]) -> list[NDArray[np.int32]]:
        """The pixels of `order` in groups that are best rendered one after the other."""
        return [order] if self.moments is None else self.moments.groups(order)

    @unit_of_work
    def render(self, unit: Unit) -> UnitResult:
        """Estimate the radiance of each of the unit's camera rays."""
        if self.moments is None:
            return self._render(unit, self.scene)
        parts = list(self.moments.parts(unit))
        results = [self._render(part.unit, self.moments.scene(part.moment)) for part in parts]
        return results[0] if len(parts) == 1 else joined(unit, parts, results)

    def _render(self, unit: Unit, moment: Scene) -> UnitResult:
        """The same where all see one moment."""
        new_paths()
        by_pixel = not moment.has_catchers
        sampler = self.lane_sampler(unit, by_pixel)
        rays = self.camera_rays(unit, sampler, moment.camera, by_pixel)
        scene = moment.for_unit(rays.o.shape[1])
        radiance = self.exposed(self._integrator.sample(scene, rays, sampler))
        caught = None if scene.caught is None else self.caught(unit, scene, radiance)
        by_group = None if scene.by_group is None else self.exposed(scene.by_group.radiance)
        alpha = scene.alpha
        if by_pixel:
            radiance = by_sample(unit, radiance)
            alpha, by_group = (None if row is None else by_sample(unit, row) for row in (alpha, by_group))
        return UnitResult(unit, radiance, alpha, scene.rays, caught, by_group)

    def caught(self, unit: Unit, scene: Scene, radiance: Float32) -> Parts:
        """The light that catchers send in the whole scene and alone, by the same random numbers."""
        new_paths()
        sampler, caught = self.lane_sampler(unit), scene.caught
        rays = self.camera_rays(unit, sampler, scene.camera)
        assert caught is not None
        assert scene.alone is not None
        rays.tfar[~caught.hit] = -1
        alone = scene.alone.for_unit(rays.o.shape[1])
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

    def scene_of(self, unit: Unit) -> Scene:
        """The scene that a unit of one pixel and one sample sees."""
        if self.moments is None:
            return self.scene
        return self.moments.scene(next(self.moments.parts(unit)).moment)

    def exposed(self, radiance: Float32) -> Float32:
        """What the film takes of a radiance (3, N): all of it unless the file sets a film exposure."""
        return radiance if self.scene.exposure == 1 else radiance * np.float32(self.scene.exposure)

    @stage("generate")
    def lane_sampler(self, unit: Unit, by_pixel: bool = False) -> LaneSampler:
        """Random numbers by (pixel of the full image, sample), sample by sample or pixel by pixel.

        Pixel by pixel neighbours see nearly the same of the scene, and a wave little of it, which Embree and
        the caches like: among half a million triangles rays take 5 % less time.
        """
        x, y = self._pixel_coordinates(unit)
        pixel = y.astype(np.uint32) * np.uint32(self._settings.width) + x.astype(np.uint32)
        sample = np.arange(unit.first, unit.first + unit.spp * unit.step, unit.step, dtype=np.uint32)
        lanes = (pixel[:, None], sample) if by_pixel else (pixel, sample[:, None])
        return LaneSampler(self._sampler, self._sampler.state(*lanes))

    @stage("generate")
    def camera_rays(self, unit: Unit, sampler: LaneSampler, camera: Camera, by_pixel: bool = False) -> Rays:
        """One ray per lane through a point drawn from the pixel filter and, with a lens, a point on it."""
        centre = np.stack(self._pixel_coordinates(unit)).astype(np.float32) + np.float32(0.5)
        raster = self._filter.sample(sampler.pixel())
        lanes = raster.reshape((2, -1, unit.spp) if by_pixel else (2, unit.spp, -1))
        lanes += centre[:, :, None] if by_pixel else centre[:, None]
        o, d, tfar = camera.rays(raster, sampler.lens() if camera.has_lens else None)
        return Rays(o, d, tfar, RayKind.CAMERA)

    def _pixel_coordinates(self, unit: Unit) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        x0, y0, x1, _ = self._settings.window
        width = np.int32(x1 - x0)
        y = unit.pixels // width  # faster than the remainder
        return unit.pixels - y * width + np.int32(x0), y + np.int32(y0)


def by_sample(unit: Unit, rows: Float32) -> Float32:
    """(..., N) pixel by pixel, put sample by sample."""
    lanes = rows.reshape(*rows.shape[:-1], len(unit.pixels), unit.spp)
    return np.ascontiguousarray(lanes.swapaxes(-1, -2)).reshape(rows.shape)


def joined(unit: Unit, parts: list[Part], results: list[UnitResult]) -> UnitResult:
    """The result of a unit from those of its parts."""
    shape = unit.spp, len(unit.pixels)
    radiance = np.empty((3, *shape), np.float32)
    first = results[0].by_group
    by_group = None if first is None else np.empty((*first.shape[:2], *shape), np.float32)
    alpha = None if results[0].alpha is None else np.empty(shape, np.float32)
    rays: Counter[str] = Counter()
    caught = None if results[0].caught is None else empty_parts(results[0].caught, radiance.shape[1:])
    for part, result in zip(parts, results, strict=True):
        size = part.unit.spp, len(part.unit.pixels)
        radiance[:, part.rows, part.columns] = result.radiance.reshape(3, *size)
        if by_group is not None and result.by_group is not None:
            by_group[..., part.rows, part.columns] = result.by_group.reshape(*by_group.shape[:2], *size)
        if alpha is not None and result.alpha is not None:
            alpha[part.rows, part.columns] = result.alpha.reshape(size)
        if caught is not None and result.caught is not None:
            put(caught, result.caught, part.rows, part.columns, size)
        rays.update(result.rays)
    return UnitResult(
        unit,
        radiance.reshape(3, -1),
        None if alpha is None else alpha.ravel(),
        rays,
        None if caught is None else flattened(caught),
        None if by_group is None else by_group.reshape(*by_group.shape[:2], -1),
    )
