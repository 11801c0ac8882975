"""Where samples that the film refused came from: each is walked again alone, after the render.

Random numbers are keyed by pixel and sample, so a lone path meets the same NaN, and the wavefront's loop
needs no tests. The first event of the path with a number that can't be is the one to blame.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from ..scene.scene import Scene
from .integrator import Integrator
from .replay import Event, Replay, replay
from .settings import RenderSettings

# densities are infinite after a Dirac bounce; directions of samples that bring nothing are arbitrary
MAY_BE_INFINITE = ("pdf BSDF", "pdf", "distance", "pdf emitter")
ARBITRARY = ("wo", "distance", "factor")
SIGNED = ("position", "normal", "wi", "wo", "origin", "direction", "distance")
ELSEWHERE: dict[str, Any] = {
    "what": "the integrator's own arithmetic",
    "bounce": 0,
    "material": "",
    "object": "",
}


def origins(
    scene: Scene, settings: RenderSettings, dropped: list[dict[str, Any]], negative: bool
) -> list[dict[str, Any]]:
    """`dropped` (x, y, sample) with what each replay finds: bounce, material, object and what it was.

    `negative` says whether numbers below 0 are as wrong as those that are not finite.
    """
    return [{**at, **found(scene, settings, at, negative)} for at in dropped]


def found(scene: Scene, settings: RenderSettings, at: dict[str, Any], negative: bool) -> dict[str, Any]:
    """What the replay of one sample finds; its failure must not cost the picture that is finished."""
    where = at["x"], at["y"], at["sample"]
    try:
        told = origin(replay(scene, settings, *where), negative)
        if told["what"] == ELSEWHERE["what"] and scene.alone is not None:
            # a shadow catcher's picture is a ratio: its samples have a second path, among catchers alone
            told = origin(replay(among_catchers(scene.alone), settings, *where), negative)
        return told
    except Exception as error:  # of a user's own integrator, which may not bear a single lane
        return ELSEWHERE | {"what": f"its replay failed: {type(error).__name__}: {error}"}


def among_catchers(alone: Scene) -> Scene:
    """The scene of catchers alone, which stand still."""
    still = copy.copy(alone)
    still.slices = None
    return still


def origin(story: Replay, negative: bool) -> dict[str, Any]:
    """What the first bad number of a path belongs to."""
    here = dict(ELSEWHERE)
    for event in story.events:
        numbers = event.numbers
        if event.what == "scatters at":
            here |= {"material": numbers["material"], "object": numbers["object"]}
        here["what"] = event.what
        name = bad_number(event, negative)
        if name:
            here["what"] = f"{event.what}: {name}"
            if "source" in numbers:
                here |= {"material": numbers["source"], "object": numbers.get("object", "")}
            return here
        if event.what == "BSDF sample":
            here["bounce"] += 1
    return ELSEWHERE | {"bounce": here["bounce"]}


def bad_number(event: Event, negative: bool) -> str:
    """Name of the first number of an event that can't be, "" where all can."""
    numbers = dict(event.numbers)
    if event.contribution is not None:
        numbers["radiance"] = event.contribution
    for name, value in numbers.items():
        if isinstance(value, str) or name in ARBITRARY:
            continue
        number = np.asarray(value, np.float64)
        infinite = np.isinf(number) & (name not in MAY_BE_INFINITE)
        below = (number < 0) & negative & (name not in SIGNED)
        if (np.isnan(number) | infinite | below).any():
            return name
    return ""


def only_positive(scene: Scene, integrator: Integrator) -> bool:
    """Whether no radiance can be below 0: no lamp, surface or sky takes light away, as far as is known.

    Emission that varies over a surface, a lamp or the sky may be anything, and so may what an integrator
    estimates that calls itself `signed`.
    """
    materials, world = scene.materials, scene.world
    used = scene.used_materials
    if world.constant is None or materials.emission_varies[used].any():
        return False
    bright = np.min(materials.emission_constant[used], initial=0) >= 0 and np.min(world.constant) >= 0
    return bool(bright) and not integrator.signed and not scene.lights.may_take_light
