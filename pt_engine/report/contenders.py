"""Who is compared: the lecture's ladder, samplers, roulette, depths, lights, clamping, where they differ.

Each is a change of the settings, or of how the prepared scene chooses its lights.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..core.samplers import SAMPLERS
from ..emitters.lights import Lights
from ..render import integrators  # noqa: F401  fills the registry
from ..render.integrator import INTEGRATORS
from ..render.settings import RenderSettings
from ..scene.scene import Scene
from ..scene.versions import changed

BASE, ADAPTIVE = "as set", "adaptive"
NO_ESTIMATOR = ("normals",)  # pictures of something else
ONE_BOUNCE = ("direct_bsdf", "direct_emitter", "direct_mis")


@dataclass(frozen=True)
class Contender:
    """Something to measure.

    Attributes
    ----------
    name : str
    settings : RenderSettings
    scene : Scene
    """

    name: str
    settings: RenderSettings
    scene: Scene


def contenders(scene: Scene, settings: RenderSettings, only: tuple[str, ...] = ()) -> list[Contender]:
    """All that make sense here; `only` keeps those whose name contains one of its words, and the base."""
    everyone = _everyone(Contender(BASE, settings, scene))
    return [c for c in everyone if c.name == BASE or not only or any(word in c.name for word in only)]


def names(scene: Scene, settings: RenderSettings) -> list[str]:
    """Of all that are compared here."""
    return [*(contender.name for contender in _everyone(Contender(BASE, settings, scene))), ADAPTIVE]


def _everyone(base: Contender) -> list[Contender]:
    """Those that are the same under two names have the first."""
    everyone = [base, *_ladder(base), *_samplers(base), *_roulette(base), *_depths(base)]
    everyone += [*_lights(base), *_clamping(base)]
    unlike = {(c.settings, id(c.scene)): c for c in reversed(everyone)}
    return [c for c in everyone if unlike[c.settings, id(c.scene)] is c]


def _changed(base: Contender, name: str, **more: object) -> Contender:
    return replace(base, name=name, settings=replace(base.settings, **more))  # type: ignore[arg-type]


def _ladder(base: Contender) -> Iterator[Contender]:
    for name in INTEGRATORS:
        if name not in NO_ESTIMATOR:
            yield _changed(base, name, integrator=name)


def _samplers(base: Contender) -> Iterator[Contender]:
    for name in SAMPLERS:
        yield _changed(base, f"sampler {name}", sampler=name)


def _roulette(base: Contender) -> Iterator[Contender]:
    if base.settings.integrator != "path":
        return
    depth = base.settings.max_depth
    yield _changed(base, "no roulette", rr_depth=depth + 1)
    for start in (2, 4, 8):
        if start < depth:
            yield _changed(base, f"roulette from {start}", rr_depth=start)


def _depths(base: Contender) -> Iterator[Contender]:
    for depth in (2, 4, 8, 16):
        if depth < base.settings.max_depth:
            yield _changed(base, f"depth {depth}", max_depth=depth)


def adaptive(base: Contender, samples: float) -> Contender:
    """Samples where the noise is: up to four times as many as the base takes everywhere."""
    return _changed(base, ADAPTIVE, adaptive=True, samples=max(64, round(4 * samples)))


def _lights(base: Contender) -> Iterator[Contender]:
    if base.scene.lights.by_place is not None:
        yield replace(base, name="lights by power", scene=by_power(base.scene))


def _clamping(base: Contender) -> Iterator[Contender]:
    yield _changed(base, "no clamping", clamp_direct=0.0, clamp_indirect=0.0)
    for limit in (10.0, 1.0):  # the first is Cycles' default
        yield _changed(base, f"clamping indirect light at {limit:g}", clamp_indirect=limit)


def by_power(scene: Scene) -> Scene:
    """The same scene, its lights chosen by their power wherever the shaded point is."""
    return changed(scene, _choose_by_power)


def _choose_by_power(scene: Scene) -> None:
    def forget_place(lights: Lights) -> None:
        lights.by_place = None

    scene.lights = scene.lights.changed(forget_place)
