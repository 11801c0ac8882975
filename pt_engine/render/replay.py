"""One sample of one pixel again, vertex by vertex.

Random numbers depend on (pixel, sample, dimension, seed) alone, so a path walks the very same way with one
lane as it did among 65,536; a recorder between the integrator and the scene notes what they say.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import Lobe
from ..core.samplers import SAMPLERS
from ..scene.geometry import INSTANCE, SKY
from ..scene.scene import Scene
from ..scene.shading import Scattered, ShadedBSDF
from ..scene.surface import Surface
from ..scene.wave import Found, Intersection, Rays
from .integrator import INTEGRATORS
from .path_state import mis
from .schedule import Unit
from .settings import RenderSettings
from .worker import Worker

if TYPE_CHECKING:
    from ..emitters.lights import LightSample
    from .path_state import PathState

Float32 = NDArray[np.float32]
LOBES = {
    Lobe.DIFFUSE: "diffuse",
    Lobe.GLOSSY: "glossy",
    Lobe.DELTA: "Dirac",
    Lobe.TRANSMIT: "transmitted",
    Lobe.TRANSPARENT: "passed through",
}


@dataclass
class Event:
    """Something that happened to the path, with its numbers, and what it added to the radiance."""

    what: str
    numbers: dict[str, Any] = field(default_factory=dict)
    contribution: Float32 | None = None


@dataclass
class Replay:
    """A path's story. `radiance` (3,) is what the film received; the contributions add up to it."""

    pixel: tuple[int, int]
    sample: int
    events: list[Event]
    radiance: Float32

    def lines(self) -> Iterator[str]:
        """The story as text, one event after the other."""
        yield f"pixel {self.pixel[0]},{self.pixel[1]}  sample {self.sample}"
        for event in self.events:
            yield event.what
            for name, value in event.numbers.items():
                yield f"    {name:<14}{_text(value)}"
            if event.contribution is not None:
                yield f"    {'+ radiance':<14}{_text(event.contribution)}"
        yield f"radiance          {_text(self.radiance)}"


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray | list | tuple):
        return "  ".join(_text(v) for v in value)
    return f"{float(value):.7g}" if isinstance(value, float | np.floating) else str(value)


def replay(scene: Scene, settings: RenderSettings, x: int, y: int, sample: int) -> Replay:
    """Walk one path again.

    Parameters
    ----------
    x, y : int
        Pixel of the full image, y up from the bottom.
    sample : int

    Raises
    ------
    ValueError
        The pixel is outside of what is rendered.
    """
    x0, y0, x1, y1 = settings.window
    if not (x0 <= x < x1 and y0 <= y < y1):
        raise ValueError(f"pixel {x},{y} is outside of the rendered window {x0},{y0} to {x1 - 1},{y1 - 1}")
    integrator = INTEGRATORS[settings.integrator](settings)
    worker = Worker(scene, settings, integrator, SAMPLERS[settings.sampler](settings.seed))
    unit = Unit(np.array([(y - y0) * (x1 - x0) + x - x0], np.int32), sample, 1)
    lanes = worker.lane_sampler(unit)
    seen = worker.scene_of(unit)
    rays = worker.camera_rays(unit, lanes, seen.camera)
    recorder = Recorder(seen.for_unit(1))
    time: dict[str, Any] = {} if seen.time is None else {"time": seen.time}
    recorder.note("camera ray", origin=rays.o[:, 0] + scene.origin32[:, 0], direction=rays.d[:, 0], **time)
    gathered = integrator.sample(cast(Scene, recorder), rays, lanes)
    radiance = worker.exposed(gathered)
    if scene.exposure != 1:
        recorder.note("film exposure", (radiance - gathered)[:, 0], factor=scene.exposure)
    return Replay((x, y), sample, recorder.events, radiance[:, 0])


class Recorder:
    """A scene for one lane that notes every question and its answer; all else is the scene's own."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.events: list[Event] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)

    def note(self, what: str, contribution: Float32 | None = None, **numbers: Any) -> None:
        """Add an event, with its numbers as they are now: the integrator goes on to change its arrays."""
        now = {name: np.copy(x) if isinstance(x, np.ndarray) else x for name, x in numbers.items()}
        self.events.append(Event(what, now, contribution))

    def intersect(self, rays: Rays) -> Intersection:
        found = self._scene.intersect(rays)
        if rays.tfar[0] > 0 and found.surface[0] == SKY:
            self.note("the ray leaves the scene")
        return found

    def surface(self, rays: Rays, found: Intersection, lanes: NDArray[np.intp]) -> Surface:
        si, scene = self._scene.surface(rays, found, lanes), self._scene
        if si.size:
            material = scene.geometry.surface_material[si.surface[0]]
            self.note(
                "scatters at",
                object=scene.instances.names[si.instance[0]],
                material=scene.material_names[material],
                distance=si.t[0],
                position=si.p[:, 0] + scene.origin32[:, 0],
                normal=si.ng[:, 0],
                wi=si.wi[:, 0],
            )
        return si

    def emission(self, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
        for light in self._scene.emission(rays, found, path):
            before = path.L[:, 0].copy()
            yield light
            if len(light.lanes):
                weight = mis(path.pdf[:1], light.pdf[:1])[0]
                numbers = {
                    **self._source(light, found),
                    "Le": light.radiance[:, 0],
                    "pdf emitter": light.pdf[0],
                    "pdf BSDF": path.pdf[0],
                }
                self.note(
                    "found an emitter", path.L[:, 0] - before, **numbers, mis=weight, beta=path.beta[:, 0]
                )

    def _source(self, light: Found, found: Intersection) -> dict[str, str]:
        """What shone: the sky, a lamp, or a surface's material and object."""
        if light.source != "surface":
            return {"source": light.source}
        scene = self._scene
        material = scene.geometry.surface_material[found.surface[0]]
        instance = scene.geometry.integer(INSTANCE, found.hits.prim[:1])[0]
        return {"source": scene.material_names[material], "object": scene.instances.names[instance]}

    def shade(
        self, si: Surface, path: PathState, spans: list[tuple[int, slice]]
    ) -> ShadedBSDF | RecordedBSDF:
        bsdf = self._scene.shade(si, path, spans)
        if si.size == 0:
            return bsdf
        used = (closure.bsdf for _, part in bsdf.slices for closure in part.closures)
        names = [getattr(module, "__name__", "?").rsplit(".", 1)[-1] for module in used]
        self.note("shaded", closures=", ".join(names), beta=path.beta[:, 0])
        return RecordedBSDF(bsdf, self)

    def sample_emitter(self, si: Surface, u: Float32, path: PathState) -> LightSample:
        return self._scene.sample_emitter(si, u, path)

    def unoccluded(
        self, si: Surface, light: LightSample, contribution: Float32, limit: int, path: PathState
    ) -> Float32:
        asked = contribution.copy()
        seen = self._scene.unoccluded(si, light, contribution, limit, path)
        dark = "no light from there" if not asked.any() else "blocked" if not seen.any() else "visible"
        self.note(
            "emitter sample",
            path.clamped(seen, slice(None), sampled=1)[:, 0].copy(),
            wo=light.wo[:, 0],
            distance=light.distance[0],
            **{"pdf emitter": light.pdf[0], "Le/pdf": light.weight[:, 0]},
            shadow_ray=dark,
        )
        return seen


class RecordedBSDF:
    """A shaded BSDF that notes what is drawn from it."""

    def __init__(self, bsdf: ShadedBSDF, recorder: Recorder) -> None:
        self._bsdf, self._recorder = bsdf, recorder
        self.smooth_count = bsdf.smooth_count

    def eval_pdf(self, wo: Float32, hidden: NDArray[np.uint8] | None = None) -> tuple[Float32, Float32]:
        value, pdf = self._bsdf.eval_pdf(wo, hidden)
        self._recorder.note("BSDF toward the emitter", **{"f·cosθ": value[:, 0], "pdf BSDF": pdf[0]})
        return value, pdf

    def sample(self, u: Float32) -> Scattered:
        s = self._bsdf.sample(u)
        lobe = int(s.lobe[0])
        words = [word for bit, word in LOBES.items() if lobe & bit] or ["absorbed"]
        self._recorder.note(
            "BSDF sample", wo=s.wo[:, 0], pdf=s.pdf[0], weight=s.weight[:, 0], lobe=", ".join(words)
        )
        return s
