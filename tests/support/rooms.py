"""A small room with something in it, for tests that need bounces, occlusion and a light."""

from __future__ import annotations

import numpy as np

from pt_engine.scene.snapshot import Graph, LightData, Link, Node, Snapshot

from . import scenes as make

UP = np.eye(4)


def room(
    material: Graph, lamp: LightData | None = None, sky: Graph | None = None, more: list = ()
) -> Snapshot:
    """A box of grey walls open to the front, something of `material` inside, and a lamp under the ceiling.

    `more` are further objects, as `scenes.scene` takes them.
    """
    floor = (make.quad(4.0), UP, make.diffuse(0.6, "floor"))
    back = (make.quad(4.0), make.translation(0, 2, 2) @ rotation_x(np.pi / 2), make.diffuse(0.4, "wall"))
    ball = (make.sphere(0.6, 24), make.translation(0.2, 0.3, 0.7), material)
    glow = (make.quad(0.8), make.translation(-0.6, 0.2, 2.4), make.emission((6.0, 5.0, 4.0), "glow"))
    objects = [floor, back, ball, *more] + ([] if lamp else [glow])
    return make.scene(objects, make.perspective((0, -5, 1.6), (0, 0, 0.9), 0.35), [lamp] if lamp else [], sky)


def rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


ROUGH = make.shader("BsdfGlossy", "rough", {"distribution": "GGX"}, Color=make.rgba(0.9), Roughness=0.4)
MIRROR = make.shader("BsdfGlossy", "mirror", {"distribution": "GGX"}, Color=make.rgba(0.9), Roughness=0.0)
GLASS = make.shader("BsdfGlass", "glass", {"distribution": "GGX"}, Color=make.WHITE, Roughness=0.3, IOR=1.4)
SOFT_LAMP = LightData("AREA", "area", make.looking((0.5, -0.5, 3.0), (0, 0, 0)), 60.0, size=(0.7, 0.7))


def half_transparent(factor: float) -> Graph:
    """Mix of Transparent (share `factor`) and Lambert."""
    nodes = (
        Node("BsdfDiffuse", "d", {"Color": make.rgba(0.7), "Roughness": 0.0}),
        Node("BsdfTransparent", "t", {"Color": make.WHITE}),
        Node("MixShader", "m", {"Fac": factor, "Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")}),
    )
    return Graph("veil", nodes, {"Surface": Link(2, "Shader")})
