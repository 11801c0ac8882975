"""Scenes that float32 and float64 render side by side (`bench.error_growth`), easy ones and hard ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np


def scenes() -> dict[str, Any]:
    """Snapshots by name."""
    from pt_engine.selftest import scenes as make

    return {
        "diffuse ball in a room": room(make.diffuse(0.75)),
        "rough metal": room(glossy(0.4)),
        "mirror": room(glossy(0.0)),
        "smooth glass": room(glass(0.0)),
        "rough glass, 10⁴ away": room(glass(0.25), 1e4),
        "sun, 60 faceted balls": faceted(),
        "60 mirror balls": mirrors(),
        "bumpy glass": room(bumpy()),
        "hair": hair(),
        "300 lamps, chosen by place": lamps(),
    }


def glossy(roughness: float) -> Any:
    """Metal."""
    from pt_engine.selftest import scenes as make

    props = {"distribution": "GGX"}
    return make.shader("BsdfGlossy", "metal", props, Color=make.rgba(0.875), Roughness=roughness)


def glass(roughness: float) -> Any:
    """Clear glass."""
    from pt_engine.selftest import scenes as make

    props = {"distribution": "GGX"}
    return make.shader("BsdfGlass", "glass", props, Color=make.WHITE, Roughness=roughness, IOR=1.5)


def bumpy() -> Any:
    """Slightly rough glass under bumps of a saw's teeth, which have edges and whose differences cancel."""
    from pt_engine.scene.snapshot import Graph, Link, Node
    from pt_engine.selftest import scenes as make

    saw = {"wave_type": "BANDS", "bands_direction": "DIAGONAL", "wave_profile": "SAW"}
    rough = {"Color": make.WHITE, "Roughness": Link(0, "Fac"), "IOR": 1.5, "Normal": Link(1, "Normal")}
    nodes = (
        Node("TexWave", "saw", {"Vector": None, "Scale": 4.0}, saw),
        Node("Bump", "bump", {"Height": Link(0, "Fac"), "Strength": 1.0, "Distance": 0.25, "Normal": None}),
        Node("BsdfGlass", "glass", rough, {"distribution": "GGX"}),
    )
    return Graph("bumpy", nodes, {"Surface": Link(2, "BSDF")})


def room(material: Any, away: float = 0.0, lit: bool = True) -> Any:
    """A ball of some material in a corner, far from the zero perhaps."""
    from pt_engine.selftest import scenes as make

    wall = np.array([[1, 0, 0, 0], [0, 0, -1, 2], [0, 1, 0, 2], [0, 0, 0, 1.0]])
    objects = [
        (make.quad(4.0), np.eye(4), make.diffuse(0.625, "floor")),
        (make.quad(4.0), wall, make.diffuse(0.375, "wall")),
        (make.sphere(0.6, 24), make.translation(0.2, 0.3, 0.7), material),
    ]
    if lit:
        lamp = make.emission((6.0, 5.0, 4.0), "lamp")
        objects.append((make.quad(0.8), make.translation(-0.6, 0.2, 2.4), lamp))
    if away:  # a speck on the other side keeps the world's middle at zero
        there = make.translation(away, away, away)
        speck = make.quad(1e-3), make.translation(-away, -away, -away), make.diffuse(0.5)
        objects = [*((mesh, there @ at, a) for mesh, at, a in objects), speck]
    eye = (away, away - 5, away + 1.6), (away, away, away + 0.9)
    return make.scene(objects, make.perspective(*eye, 0.35, aspect=1.5), [], make.world(0.25))


def balls(material: Any, smooth: bool) -> Any:
    """60 small ones over a floor."""
    from pt_engine.selftest import scenes as make

    rng = np.random.default_rng(3)
    places = [make.translation(*rng.uniform((-2, -2, 0), (2, 2, 2))) for _ in range(60)]
    mesh = make.sphere(0.15, 8, smooth=False) if not smooth else make.sphere(0.35, 24)
    every = [(mesh, at, material) for at in places]
    floor = (make.quad(9.0), np.eye(4), make.diffuse(0.5))
    camera = make.perspective((0, -6, 2.5), (0, 0, 0.8), 0.35, aspect=1.5)
    return make.scene([*every, floor], camera, [], make.world(0.25))


def sun() -> Any:
    """A small one."""
    from pt_engine.scene.snapshot import LightData
    from pt_engine.selftest import scenes as make

    return LightData("SUN", "sun", make.looking((3, -2, 4), (0, 0, 0)), 3.0, angle=0.02)


def faceted() -> Any:
    """Diffuse balls with faces under a sun."""
    from pt_engine.selftest import scenes as make

    return replace(balls(make.diffuse(0.75), smooth=False), lights=(sun(),))


def mirrors() -> Any:
    """Between mirror balls an error grows tenfold with each reflection."""
    return replace(balls(glossy(0.0), smooth=True), lights=(sun(),))


def hair() -> Any:
    """A tuft of thin bent strands, round and flat, over a floor."""
    from pt_engine.scene.snapshot import CurvesData
    from pt_engine.selftest import scenes as make

    rng, count, each = np.random.default_rng(1), 150, 5
    step = rng.normal(0, 0.12, (count, each - 1, 3)) + [0, 0, 0.25]
    points = np.concatenate([np.zeros((count, 1, 3)), np.cumsum(step, axis=1)], axis=1)
    points += rng.uniform(-1, 1, (count, 1, 3)) * [1, 1, 0]
    first = np.arange(0, count * each + 1, each, dtype=np.int32)
    radius = np.tile(np.linspace(0.02, 0.004, each), count).astype(np.float32)
    tufts = [
        CurvesData(shape, points.reshape(-1, 3).astype(np.float32) + shift, radius, first,
                   np.zeros(count, np.int32), shape)
        for shape, shift in (("THICK", np.float32(0)), ("RIBBON", np.float32(0.05)))
    ]  # fmt: skip
    floor = (make.quad(6.0), np.eye(4), make.diffuse(0.5))
    camera = make.perspective((0, -5, 2.0), (0, 0, 0.5), 0.3, aspect=1.5)
    return make.among(make.scene([floor], camera, [sun()], make.world(0.25)), tufts)


def lamps() -> Any:
    """Small spheres near the surfaces: choices by cells, whose edges are decisions."""
    from pt_engine.scene.snapshot import LightData
    from pt_engine.selftest import scenes as make

    rng = np.random.default_rng(2)
    every = [
        LightData("POINT", "lamp", make.translation(*rng.uniform((-1.8, -1.8, 0.1), (1.8, 1.8, 2))),
                  float(rng.exponential(0.5)), radius=0.02)
        for _ in range(300)
    ]  # fmt: skip
    return replace(room(make.diffuse(0.75), lit=False), lights=tuple(every))
