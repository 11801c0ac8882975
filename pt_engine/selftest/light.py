"""Light that is too small, too near, too bright, too dim, too many, or not a number."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..emitters.environment import EnvironmentMap, texel_directions
from ..emitters.lights import Lights
from ..emitters.many import Surfaces
from ..scene.accel import Accel
from ..scene.snapshot import LightData
from . import scenes as make
from .case import Group
from .geometry import FLOOR, worst

LIGHT = Group("Light")
Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
NONE = float("nan")
DOWN = np.diag([1.0, 1.0, 1.0, 1.0])


def lamp(kind: str, height: float = 1.0, power: float = 1.0, **more: Any) -> LightData:
    """A lamp over the origin that shines down."""
    return LightData(kind, kind, make.translation(0, 0, height), power, **more)


def irradiance(*lamps: LightData, n: int = 4096, **more: Any) -> float:
    """On a plane through the origin that faces up, by sampling emitters; NaN if any number is not finite."""
    lights = Lights(lamps, scene_radius=3.0, **more)
    k = np.arange(n)
    u = np.stack([(k + 0.5) / n, k * 0.7548776662 % 1, k * 0.5698402910 % 1]).astype(np.float32)
    here = np.zeros((3, n), np.float32)
    up = here + np.array([[0], [0], [1]], np.float32)
    s = lights.sample(here, up, np.minimum(u[[1, 0, 2]], np.float32(1 - 2**-24)))
    met = list(lights.intersect(here, s.wo, np.full(n, np.inf, np.float32)))
    numbers = [*s.wo, s.distance, *s.weight, s.pdf, *(x.ravel() for h in met for x in (h.radiance, h.pdf))]
    if not np.isfinite(np.concatenate(numbers)).all():
        return NONE
    return float((s.weight[0].astype(np.float64) * np.maximum(s.wo[2], 0)).mean())


@LIGHT.case(
    "a sun of 1e6 beside one of 1e-6",
    "the choice by power would give the dim one a chance of 1e-12, below a uniform's 2⁻²⁴",
    "irradiance of the dim one alone, found through the common choice, over its true one",
    1.0,
    1e-3,
    "a hundredth of all choices goes evenly to all: 20 of 4,096 samples",
)
def two_suns() -> float:
    bright, dim = lamp("SUN", power=1e6), lamp("SUN", power=1e-6, color=(0.0, 1.0, 0.0))
    lights = Lights([bright, dim], scene_radius=3.0)
    n = 1 << 16
    u = np.stack([(np.arange(n) + 0.5) / n, np.full(n, 0.5), np.full(n, 0.5)]).astype(np.float32)
    s = lights.sample(np.zeros((3, n), np.float32), np.zeros((3, n), np.float32), u)
    only = np.asarray(s.emitter) == list(lights.names).index("SUN") + int(lights.power[0] > lights.power[1])
    return float((s.weight[1].astype(np.float64) * only).mean() / 1e-6)


@LIGHT.case(
    "point lights at 1e-6 and 1e-4 from a surface",
    "1/d² is 1e12",
    "irradiance times d², over the intensity",
    1.0,
    1e-6,
    "rounding",
)
def near_points() -> float:
    return worst([irradiance(lamp("POINT", h)) * h * h * 4 * np.pi for h in (1e-6, 1e-4)], 1.0)


@LIGHT.case(
    "balls of light from 1 m to 1e-19 m and none at all",
    "1 − cosθ of the cone cancels, r² underflows, Φ/r² overflows",
    "irradiance 2 m below, over that of a point",
    1.0,
    0.01,
    "midpoints of 4,096 cells",
)
def small_spheres() -> float:
    point = irradiance(lamp("POINT", 2.0))
    radii = (1.0, 1e-3, 1e-6, 1e-12, 1e-19, 1e-21, 1e-30)
    return worst([irradiance(lamp("POINT", 2.0, radius=r)) / point for r in radii], 1.0)


@LIGHT.case(
    "spots of 0° to 180°, sharp and soft, with and without size",
    "an empty cone has density 1/0, a half-space the tangent of 90°",
    "irradiance under the wide ones over a point's, 0 under the closed ones: largest deviation",
    0.0,
    0.01,
    "midpoints of 4,096 cells",
)
def spots() -> float:
    point = irradiance(lamp("POINT", 2.0))
    deviation = []
    for radius in (0.0, 0.3):
        for blend in (0.0, 1e-9):
            for angle, expected in ((0.0, 0.0), (1e-9, 0.0), (np.pi, 1.0), (3.2, 1.0)):
                spot = lamp("SPOT", 2.0, radius=radius, spot_size=angle, spot_blend=blend)
                deviation.append(abs(irradiance(spot) / point - expected))
    return NONE if np.isnan(deviation).any() else max(deviation)


@LIGHT.case(
    "suns of 1e-9° to 180°",
    "a disc of the sky smaller than float32's spacing of directions, and one that is half of it",
    "irradiance over the strength",
    1.0,
    1e-3,
    "midpoints of 4,096 cells",
)
def suns() -> float:
    return worst(
        [irradiance(lamp("SUN", angle=a)) for a in (0.0, 1e-11, 1e-7, 1e-4, 0.01, 1.0, np.pi, 6.0)], 1.0
    )


@LIGHT.case(
    "area lights of zero width, and down to 1e-25",
    "Φ/A is ∞; Cycles lets a lamp without area shine nothing",
    "irradiance 1 m below those with area over Φ/π, added to that of those without",
    1.0,
    1e-3,
    "midpoints; a square of 0.01 is seen at an angle",
)
def no_area() -> float:
    empty = [
        irradiance(lamp("AREA", size=(0.0, 0.0))),
        irradiance(lamp("AREA", shape="RECTANGLE", size=(1.0, 0.0))),
    ]
    small = [
        irradiance(lamp("AREA", shape=shape, size=(s, s))) * np.pi
        for shape in ("SQUARE", "DISK")
        for s in (1e-2, 1e-6, 1e-12, 1e-18, 1e-25)
    ]
    return worst(small, 1.0) + sum(empty)


@LIGHT.case(
    "an area light that touches the surface",
    "sampled by area its density is t²/cosθ: almost all samples bring nothing, a few 1e12",
    "irradiance under a square of 1 at a height of 1e-6, over π times its radiance",
    1.0,
    1e-4,
    "uniform in solid angle: the mean of cosθ over a hemisphere, by 4,096 midpoints",
    naive=lambda: touching_by_area(),
)
def touching() -> float:
    return irradiance(lamp("AREA", 1e-6, size=(1.0, 1.0)))


def touching_by_area(n: int = 4096) -> float:
    """Φ/(π A) cosθ cosθ' A/t² at points drawn uniformly in area."""
    k = np.arange(n)
    x, y = (k + 0.5) / n - 0.5, k * 0.7548776662 % 1 - 0.5
    t2 = x * x + y * y + 1e-12
    return float((1e-12 / (t2 * t2)).mean() / np.pi)


@LIGHT.case(
    "area lights edge-on and from behind",
    "cosθ' is 0: a density of ∞, or 0/0",
    "irradiance of a lamp in the plane of the lit point, and of one that faces away",
    0.0,
    1e-9,
    "none",
)
def edge_on() -> float:
    turned = make.translation(2.0, 0, 0) @ np.array(
        [[0.0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]]
    )
    flat = make.translation(2.0, 0, 0)
    values = []
    for shape in ("SQUARE", "DISK"):
        for matrix in (flat, turned, make.translation(0, 0, -1.0)):
            values.append(irradiance(LightData("AREA", "a", matrix, 1.0, shape=shape)))
    return NONE if np.isnan(values).any() else max(values)


@LIGHT.case(
    "negative lamps",
    "a shadow ray is traced only where light arrives; less than none is light, too",
    "radiance of a floor under a sky and two lamps that cancel, over that under the sky alone",
    1.0,
    5e-3,
    "noise",
)
def negative() -> float:
    sky = make.world(1.0)
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 0.9)
    values = []
    for lamps in ([lamp("POINT", 2.0, 5.0), lamp("POINT", 2.0, -5.0)], []):
        snapshot = make.scene([(FLOOR, np.eye(4), make.diffuse(0.5))], camera, lamps, sky)
        result = make.rendered(snapshot, 8, samples=256, sampler="sobol", max_depth=2)
        values.append(float(result.image()[..., :3].mean()))
    return values[0] / values[1]


@LIGHT.case(
    "surfaces that take light away",
    "an emission below 0 is no emission to whoever asks for more than 0",
    "mean radiance of a floor below a square of −1 and one of 1, over that below a black one",
    1.0,
    5e-3,
    "noise",
)
def negative_surfaces() -> float:
    camera = make.orthographic((0, 0, 0.5), (0, 0, 0), 0.5)
    floor = (FLOOR, np.eye(4), make.diffuse(0.5))
    squares = [
        (make.quad(1.0), make.translation(0, 0, 1.0), make.emission(radiance, f"emission {radiance}"))
        for radiance in (-1.0, 1.0)
    ]
    shade = [(mesh, matrix, make.diffuse(0.0)) for mesh, matrix, _ in squares[:1]]
    values = []
    for objects in ([floor, squares[0]], [floor, squares[1]], [floor, *shade]):
        snapshot = make.scene(objects, camera, sky=make.world(1.0))
        result = make.rendered(snapshot, 8, samples=256, sampler="sobol", max_depth=2)
        values.append(float(result.image()[..., :3].mean()))
    return (values[0] + values[1]) / (2 * values[2])


def sky_of(image: Float64) -> EnvironmentMap:
    """An environment that looks its radiance up in an image without interpolation."""
    height, width = image.shape

    def radiance(d: Float32) -> Float32:
        row = ((1 - np.arccos(np.clip(d[2], -1, 1)) / np.pi) * height).astype(int).clip(0, height - 1)
        column = ((0.5 - np.arctan2(d[1], d[0]) / (2 * np.pi)) * width).astype(int) % width
        return np.repeat(image[row, column].astype(np.float32)[None], 3, axis=0)

    return EnvironmentMap(image.astype(np.float32), radiance)


def sky_image(height: int = 32) -> Float64:
    """Even."""
    return np.ones((height, 2 * height))


@LIGHT.case(
    "an environment with one hot pixel",
    "all of the light in 1e-4 of the sky, 1e9 times as bright",
    "irradiance over that of the pixel",
    1.0,
    0.02,
    "half of the samples go to its neighbours, as interpolation asks for",
)
def hot_pixel() -> float:
    image = sky_image() * 0.0
    image[24, 5] = 1e9
    d = texel_directions(32, 64)[:, 24 * 64 + 5]
    edges = -np.cos(np.pi * np.arange(24, 26) / 32)
    exact = 1e9 * d[2] * 2 * np.pi / 64 * (edges[1] - edges[0])
    return irradiance(environment=sky_of(image), n=1 << 15) / float(exact)


@LIGHT.case(
    "an environment all black, or with texels of NaN and infinity",
    "sums and tables of what is no number",
    "irradiance of the black one, plus the mean density's deviation from 1/4π with broken texels",
    0.0,
    1e-5,
    "a broken texel counts as black for the choice of directions",
)
def broken_sky() -> float:
    black = irradiance(environment=sky_of(sky_image() * 0))
    image = sky_image()
    image[3, 3], image[20, 40], image[9, 9] = np.nan, np.inf, -5.0
    environment = EnvironmentMap(image.astype(np.float32), lambda d: np.ones_like(d))
    d = texel_directions(64, 128)
    solid = np.repeat(np.diff(-np.cos(np.pi * np.arange(65) / 64)), 128) * 2 * np.pi / 128
    return black + abs(float((environment.pdf(d) * solid).sum()) - 1)


@LIGHT.case(
    "the poles of an environment",
    "a density per direction is one per image area over sinθ: 0/0 at the pole",
    "density at the poles times 4π, the worst",
    1.0,
    0.01,
    "the image is even, its rows' solid angles exact",
    naive=lambda: float(np.float32(1 / (2 * np.pi**2)) / np.sin(np.float32(0.0)) * 4 * np.pi),
)
def poles() -> float:
    environment = sky_of(sky_image())
    d = np.array([[0, 0, 1], [0, 0, -1], [-0.0, 0, 1.0000001]], np.float32).T.copy()
    return worst([float(p) * 4 * np.pi for p in environment.pdf(d)], 1.0)


@LIGHT.case(
    "100,000 lights, most without power",
    "tables of all; a choice by 24 bits among 1e5",
    "irradiance of the ten that shine",
    1.0,
    1e-3,
    "midpoints of 4,096 cells in the choice",
    quick=False,
)
def many() -> float:
    lamps = [lamp("POINT", 1.0, 4 * np.pi / 10 if k % 10_000 == 0 else 0.0) for k in range(100_000)]
    return irradiance(*lamps)


@LIGHT.case(
    "one light, and 20,000 that shine, chosen by place",
    "a choice of groups in alias tables by cells: its probabilities are products of rounded shares",
    "irradiance of a ring of them around the point over E = Φh/4π(r² + h²)^(3/2)",
    1.0,
    0.02,
    "midpoints of 4,096 cells in the choice, a fifth of the lights",
    quick=False,
)
def by_place() -> float:
    corners = np.array([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], np.float32)
    floor = Surfaces(corners, np.array([(0, 1, 2), (0, 2, 3)], np.int32), True, Accel)
    return worst([ring(count, floor) for count in (1, 20_000)], 1.0)


def ring(count: int, floor: Surfaces) -> float:
    """Irradiance at the middle of a ring of lamps of 1 W in all, 2 m wide and 1 m up, over the exact one."""
    turn = 2 * np.pi * np.arange(count) / count
    places = [make.translation(np.cos(a), np.sin(a), 1.0) for a in turn]
    lamps = [LightData("POINT", "one", place, 1.0 / count) for place in places]
    return irradiance(*lamps, surfaces=floor) * 4 * np.pi * 2**1.5
