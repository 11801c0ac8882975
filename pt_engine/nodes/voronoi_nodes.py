"""The Voronoi Texture node: features, and octaves of them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from . import voronoi
from .coordinates import coordinates
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Op, Static, Value, op
from .math_nodes import divide, select
from .noise import Octaves
from .noise_nodes import point_of
from .registry import Outputs, node
from .voronoi import Octave
from .voronoi_cells import Point, Settings, distance

Float32 = NDArray[np.float32]
ONE: Final = np.ones(1, np.float32)
TWO: Final = ("F1", "F2")


def _settings(feature: str, metric: str, *inputs: Float32) -> Settings:
    exponent, randomness, smoothness = inputs
    return Settings(feature, metric, exponent, np.clip(randomness, 0, 1), np.clip(smoothness * 0.5, 0, 0.5))


def one_octave(settings: Settings, point: Point) -> Octave:
    """The feature at one scale."""
    if settings.feature == "F2":
        return voronoi.f2(settings, point)
    if settings.feature == "SMOOTH_F1" and (settings.smoothness != 0).any():
        smooth = voronoi.smooth_f1(settings, point)
        if (settings.smoothness != 0).all():
            return smooth
        sharp, on = voronoi.f1(settings, point), settings.smoothness != 0
        position = [select(on, a, b) for a, b in zip(smooth.position, sharp.position, strict=True)]
        return Octave(
            select(on, smooth.distance, sharp.distance), select(on, smooth.color, sharp.color), position
        )
    return voronoi.f1(settings, point)


def lerp(a: Float32, b: Float32, t: Float32) -> Float32:
    """a + t(b − a)."""
    out: Float32 = a + t * (b - a)
    return out


def farthest(settings: Settings, dimension: int) -> Float32:
    """The greatest distance a feature can have, for Normalize."""
    half = np.float32(0.5) + np.float32(0.5) * settings.randomness
    reach = half if dimension == 1 else distance(settings, [half.copy() for _ in range(dimension)])
    return reach * 2 if settings.feature == "F2" else reach


def fractal(
    settings: Settings, point: Point, detail: Float32, roughness: Float32, lacunarity: Float32
) -> tuple[Octave, Float32]:
    """Octaves of a feature added up, and the sum of their amplitudes."""
    roughness = np.clip(roughness, 0, 1)
    octaves = Octaves(select(roughness == 0, np.float32(0), detail))
    out = one_octave(settings, point)
    if octaves.last == 0 and not octaves.any_rest:
        return out, ONE
    distance, color, place = out.distance, out.color, list(out.position)
    reach, amplitude, scale = ONE, roughness, lacunarity
    for i in octaves.numbers[1:]:
        part = one_octave(settings, [p * scale for p in point])
        share = (octaves.has(i) + octaves.is_next(i) * octaves.rest) * amplitude
        distance, color = distance + share * part.distance, color + share * part.color
        place = [lerp(a, divide(b, scale), share) for a, b in zip(place, part.position, strict=True)]
        reach = reach + share
        amplitude, scale = amplitude * roughness, scale * lacunarity
    return Octave(distance, color, place), reach


def fractal_edge(
    settings: Settings, point: Point, detail: Float32, roughness: Float32, lacunarity: Float32
) -> tuple[Float32, Float32]:
    """Octaves of the distance to an edge: the smallest wins; and its greatest possible value."""
    roughness = np.clip(roughness, 0, 1)
    longest = np.float32(0.5) + np.float32(0.5) * settings.randomness
    octaves = Octaves(select(roughness == 0, np.float32(0), detail))
    distance = voronoi.edge_distance(settings, point)
    if octaves.last == 0 and not octaves.any_rest:
        return distance, longest
    reach = longest
    distance = np.minimum(distance, 8)
    amplitude, scale = roughness, lacunarity
    for i in octaves.numbers[1:]:
        part = divide(voronoi.edge_distance(settings, [p * scale for p in point]), scale)
        share = octaves.has(i) + octaves.is_next(i) * octaves.rest
        closer = lerp(distance, np.minimum(distance, part), amplitude)
        distance = lerp(distance, np.minimum(distance, closer), np.asarray(share, np.float32))
        reach = lerp(reach, lerp(reach, divide(longest, scale), amplitude), np.asarray(share, np.float32))
        amplitude, scale = amplitude * roughness, scale * lacunarity
    return distance, reach


def _inputs(
    feature: str, metric: str, dimensions: int, inputs: tuple[Float32, ...]
) -> tuple[Settings, list[Float32], Float32, Float32, Float32]:
    vector, w, scale, detail, roughness, lacunarity, *rest = inputs
    settings = _settings(feature, metric, *rest)
    return settings, point_of(dimensions, vector, w, scale), np.clip(detail, 0, 15), roughness, lacunarity


INPUTS: Final = (
    *("vector", "w", "scale", "detail", "roughness", "lacunarity"),
    *("exponent", "randomness", "smoothness"),
)


def _with_the_other(feature: str, *static: Any) -> tuple[Op, Static, int] | None:
    return (voronoi_distances, static, TWO.index(feature)) if feature in TWO else None


@op(FLOAT, rest=INPUTS, joint=_with_the_other, dear=True)
def voronoi_distance(
    feature: str, metric: str, dimensions: int, normalize: bool, *inputs: Float32
) -> Float32:
    """Distance of the F1, F2 and Smooth F1 features."""
    settings, point, detail, *_ = _inputs(feature, metric, dimensions, inputs)
    if settings.feature == "SMOOTH_F1" or (detail != 0).any():
        whole: Float32 = voronoi_points(feature, metric, dimensions, normalize, *inputs)[0]
        return whole
    distance = voronoi.distances(settings, point)
    return divide(distance, farthest(settings, dimensions)) if normalize else distance


@op(FLOAT, FLOAT, rest=INPUTS, dear=True)
def voronoi_distances(
    metric: str, dimensions: int, normalize: bool, *inputs: Float32
) -> tuple[Float32, Float32]:
    """Distances of the F1 and the F2 feature."""
    settings, point, detail, *_ = _inputs("F2", metric, dimensions, inputs)
    if (detail != 0).any():
        first, second = (voronoi_distance(f, metric, dimensions, normalize, *inputs) for f in TWO)
        return first, second
    first, second = voronoi.two_distances(settings, point)
    if normalize:
        first = divide(first, farthest(settings._replace(feature="F1"), dimensions))
        second = divide(second, farthest(settings, dimensions))
    return first, second


@op(FLOAT, COLOR, VECTOR, FLOAT, rest=INPUTS, alone=voronoi_distance, dear=True)
def voronoi_points(
    feature: str, metric: str, dimensions: int, normalize: bool, *inputs: Float32
) -> tuple[Float32, Float32, Float32, Float32]:
    """Distance, colour, position and W of the F1, F2 and Smooth F1 features."""
    settings, point, detail, roughness, lacunarity = _inputs(feature, metric, dimensions, inputs)
    out, reach = fractal(settings, point, detail, roughness, lacunarity)
    distance, color = out.distance, out.color
    if normalize:
        distance = divide(distance, reach * farthest(settings, dimensions))
        color = color / reach
    scale = inputs[2]
    place = [divide(p, scale) for p in out.position]
    zero = np.zeros_like(place[0])
    w = place[-1] if dimensions in (1, 4) else zero
    axes = [] if dimensions == 1 else place[:3]
    position = np.stack(np.broadcast_arrays(*axes, *[zero] * (3 - len(axes))))
    return distance, color, position, w


@op(FLOAT, rest=INPUTS, dear=True)
def voronoi_edge(feature: str, metric: str, dimensions: int, normalize: bool, *inputs: Float32) -> Float32:
    """Distance to the nearest edge."""
    settings, point, detail, roughness, lacunarity = _inputs(feature, metric, dimensions, inputs)
    distance, reach = fractal_edge(settings, point, detail, roughness, lacunarity)
    return divide(distance, reach) if normalize else distance


@op(FLOAT, rest=INPUTS, dear=True)
def voronoi_radius(feature: str, metric: str, dimensions: int, normalize: bool, *inputs: Float32) -> Float32:
    """Radius of the n-sphere inside the cell."""
    settings, point, *_ = _inputs(feature, metric, dimensions, inputs)
    return voronoi.sphere_radius(settings, point)


FEATURES: Final = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")


@node("TexVoronoi")
def tex_voronoi(n: NodeView) -> Outputs:
    feature = str(n.prop("feature", "F1"))
    dimensions = int(str(n.prop("voronoi_dimensions", "3D"))[0])
    if feature not in FEATURES:
        n.approximate(f"feature {feature} is not understood: F1")
        feature = "F1"
    vector = coordinates(n)
    names = (
        ("W", 0.0),
        ("Scale", 5.0),
        ("Detail", 0.0),
        ("Roughness", 0.5),
        ("Lacunarity", 2.0),
        ("Exponent", 0.5),
        ("Randomness", 1.0),
        ("Smoothness", 1.0),
    )
    inputs = [vector, *(n.float(name, default) for name, default in names)]
    normalize = bool(n.prop("normalize", False))
    static = (feature, str(n.prop("distance", "EUCLIDEAN")), dimensions, normalize)
    zero, zeros = n.constant(0.0, FLOAT), n.constant(0.0, VECTOR)
    out: dict[str, Value | None] = {
        "Distance": zero,
        "Color": n.constant(0.0, COLOR),
        "Position": zeros,
        "W": zero,
        "Radius": zero,
    }
    if feature == "DISTANCE_TO_EDGE":
        out["Distance"] = n.call(voronoi_edge, *inputs, static=static)
    elif feature == "N_SPHERE_RADIUS":
        out["Radius"] = n.call(voronoi_radius, *inputs, static=static)
    else:
        points = n.calls(voronoi_points, *inputs, static=static)
        out.update(zip(("Distance", "Color", "Position", "W"), points, strict=True))
    return out
