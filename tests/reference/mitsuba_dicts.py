"""Small scenes as Mitsuba dicts, for `mitsuba.load_dict` and for our loader alike."""

from __future__ import annotations

from typing import Any

import numpy as np

SIZE = (48, 36)


def rgb(r: float, g: float | None = None, b: float | None = None) -> dict[str, Any]:
    return {"type": "rgb", "value": [r, r if g is None else g, r if b is None else b]}


def looking(eye: tuple[float, float, float], target: tuple[float, float, float]) -> dict[str, Any]:
    """Mitsuba's camera transform: +Z toward the target, +X to the left, +Y up."""
    z = np.subtract(target, eye)
    z = z / np.linalg.norm(z)
    x = np.cross((0, 1, 0), z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), eye
    return {"matrix": matrix.tolist()}


def placed(x: float, y: float, z: float, size: float, turn: float = 0.0) -> dict[str, Any]:
    """A scale, a turn about X (degrees), a shift."""
    c, s = np.cos(np.radians(turn)) * size, np.sin(np.radians(turn)) * size
    return {"matrix": [[size, 0, 0, x], [0, c, -s, y], [0, s, c, z], [0, 0, 0, 1]]}


def scene(max_depth: int, **parts: dict[str, Any]) -> dict[str, Any]:
    """The parts seen from the front."""
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}}
    sensor = {
        "type": "perspective",
        "fov": 40.0,
        "fov_axis": "x",
        "to_world": looking((0, 1.5, 5), (0, 0.5, 0)),
        "film": film | {"pixel_format": "rgb"},
    }
    path = {"type": "path", "max_depth": max_depth}
    return {"type": "scene", "integrator": path, "sensor": sensor, **parts}


def twosided(bsdf: dict[str, Any]) -> dict[str, Any]:
    return {"type": "twosided", "bsdf": bsdf}


def diffuse(*colour: float) -> dict[str, Any]:
    return twosided({"type": "diffuse", "reflectance": rgb(*colour)})


def ball(bsdf: dict[str, Any], x: float = 0.0, radius: float = 0.8) -> dict[str, Any]:
    return {"type": "sphere", "center": [x, radius, 0.0], "radius": radius, "bsdf": bsdf}


def metal(alpha: float, distribution: str) -> dict[str, Any]:
    return twosided(
        {
            "type": "roughconductor",
            "distribution": distribution,
            "alpha": alpha,
            "eta": rgb(0.143, 0.375, 1.44),  # gold
            "k": rgb(3.98, 2.39, 1.6),
        }
    )


def plastic(*colour: float, **settings: Any) -> dict[str, Any]:
    indices = {"int_ior": 1.49, "ext_ior": 1.0}
    return twosided({"diffuse_reflectance": rgb(*colour), **indices, **settings})


FLOOR = {"type": "rectangle", "to_world": placed(0, 0, 0, 4, -90), "bsdf": diffuse(0.6, 0.5, 0.4)}
LAMP = {
    "type": "rectangle",
    "to_world": placed(0, 3, 0.5, 0.6, 90),
    "bsdf": {"type": "diffuse", "reflectance": rgb(0.0)},
    "emitter": {"type": "area", "radiance": rgb(12, 10, 8)},
}
SKY = {"type": "constant", "radiance": rgb(0.4, 0.5, 0.6)}
GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
FROSTED = {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0, "alpha": 0.2, "distribution": "ggx"}

DICTS: dict[str, tuple[dict[str, Any], int]] = {
    "furnace": (scene(20, ball=ball(diffuse(0.8)), sky={"type": "constant", "radiance": rgb(1.0)}), 32),
    "diffuse": (scene(8, floor=FLOOR, lamp=LAMP, ball=ball(diffuse(0.7, 0.3, 0.2)), sky=SKY), 128),
    "point": (
        scene(
            6,
            floor=FLOOR,
            lamp={"type": "point", "position": [1.5, 3, 2], "intensity": rgb(20, 16, 12)},
            ball=ball(diffuse(0.7, 0.3, 0.2)),
        ),
        64,
    ),
    "ggx": (
        scene(
            6,
            floor=FLOOR,
            lamp=LAMP,
            smooth=ball(metal(0.1, "ggx"), -0.8, 0.7),
            rough=ball(metal(0.4, "ggx"), 0.8, 0.7),
            sky=SKY,
        ),
        128,
    ),
    "plastic": (
        scene(
            8,
            floor=FLOOR,
            lamp=LAMP,
            rough=ball(
                plastic(0.1, 0.3, 0.9, type="roughplastic", distribution="ggx", alpha=0.1, nonlinear=True),
                -0.8,
                0.7,
            ),
            smooth=ball(plastic(0.9, 0.3, 0.1, type="plastic"), 0.8, 0.7),
            sky=SKY,
        ),
        128,
    ),
    "beckmann": (scene(6, floor=FLOOR, lamp=LAMP, ball=ball(metal(0.25, "beckmann")), sky=SKY), 128),
    "glass": (scene(12, floor=FLOOR, ball=ball(GLASS), sky=SKY), 128),
    "frosted": (scene(12, floor=FLOOR, ball=ball(FROSTED), sky=SKY), 128),
}
