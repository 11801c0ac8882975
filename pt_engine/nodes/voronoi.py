"""The Voronoi texture: distances to the random points of a grid's cells, value for value Blender's.

Each cell of the integer grid holds one point; features look at the 3ᵈ cells around (5ᵈ for the smooth
one). After Inigo Quilez' articles on Voronoi edges and smooth Voronoi. Mostly the 2ᵈ cells on the lane's side
are enough to be sure of the nearest point. Blocks of lanes are small enough to stay in cache.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .math_nodes import divide, smooth_step
from .voronoi_cells import (
    FAR,
    Cells,
    Float32,
    Nearest,
    Point,
    Settings,
    distance,
    neighbours,
    smallest,
    sum_of_squares,
    two_smallest,
)
from .voronoi_grids import grid_around

BLOCK: Final = 65536  # cells at a time
FEW: Final = 512  # lanes for which two ways cost more than one
MUCH: Final = 0.5  # randomness beyond which points are often far
NO_BORDER: Final = np.float32(0.0001)  # squared distance of points up to which there is none between them
SURE: Final = np.float32(1 - 1e-5)  # rounding aside


class Octave(NamedTuple):
    """What one octave gives: distance (n,), colour (3, n), position of the point by axis."""

    distance: Float32
    color: Float32
    position: list[Float32]


Arrays = tuple[NDArray[Any], ...]
Kernel = Callable[[Cells], Arrays]


def in_blocks(kernel: Kernel, settings: Settings, point: Point, cells: int = 3) -> Arrays:
    """What `kernel` gives, a block of lanes at a time, of which each looks at so many cells an axis."""
    size = max(a.shape[-1] for a in (*point, *settings[2:]))
    count = cells ** len(point)
    step, grid, parts = max(BLOCK // count, 1), grid_around(point, count), []
    for start in range(0, size, step):
        span = slice(start, min(start + step, size))
        parts.append(kernel(Cells(settings.of(span), [np.broadcast_to(p, size)[span] for p in point], grid)))
    if len(parts) == 1:
        return parts[0]
    return tuple(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))


def mostly_near(near: Kernel, kernel: Kernel, settings: Settings, point: Point) -> Arrays:
    """What `kernel` gives; by `near`, which also says where it is sure, on most lanes."""
    size = max(a.shape[-1] for a in (*point, *settings[2:]))
    if size < FEW or len(point) == 1 or not _is_mostly_sure(settings):
        return in_blocks(kernel, settings, point)
    *found, sure = in_blocks(near, settings, point, cells=2)
    lanes = np.flatnonzero(~sure)
    if len(lanes):
        again = in_blocks(kernel, settings.of(lanes), [np.broadcast_to(p, size)[lanes] for p in point])
        for value, better in zip(found, again, strict=True):
            value[..., lanes] = better
    return tuple(found)


def _is_mostly_sure(settings: Settings) -> bool:
    """Whether points beyond the nearer cells are seldom the nearest; no length is less than along an axis."""
    if settings.feature == "F2" or settings.metric == "MANHATTAN":
        return bool((settings.randomness <= MUCH).all()) and settings.metric != "MINKOWSKI"
    return settings.metric != "MINKOWSKI"


def _octave(found: Arrays) -> Octave:
    return Octave(found[0], found[1], list(found[2:]))


def _ways(cells: Cells, points: list[Float32]) -> list[Float32]:
    """From the lanes' points to those of the cells."""
    return [p - q for p, q in zip(points, cells.local, strict=True)]


def _ways_alone(cells: Cells, points: list[Float32]) -> list[Float32]:
    """The same in the points' memory."""
    return [np.subtract(p, q, out=p) for p, q in zip(points, cells.local, strict=True)]


def f1(settings: Settings, point: Point) -> Octave:
    """The nearest point."""
    return _octave(mostly_near(_near_f1, _f1, settings, point))


def _f1(cells: Cells) -> tuple[Float32, ...]:
    points = cells.points()
    return cells.octave(Nearest(distance(cells.settings, _ways(cells, points))), points)


def _near_f1(cells: Cells) -> Arrays:
    offset, far = cells.near()
    points = cells.points_at(offset)
    nearest = Nearest(distance(cells.settings, _ways(cells, points)))
    return *cells.octave(nearest, points, offset), nearest.distance < far * SURE


def f2(settings: Settings, point: Point) -> Octave:
    """The second nearest point."""
    return _octave(in_blocks(_f2, settings, point))


def _f2(cells: Cells) -> tuple[Float32, ...]:
    points = cells.points()
    distances = np.array(distance(cells.settings, _ways(cells, points)))
    distances.reshape(-1)[Nearest(distances).index] = FAR
    return cells.octave(Nearest(distances), points)


def distances(settings: Settings, point: Point) -> Float32:
    """(n,) distance of `f1`, or of `f2`, without what else they give."""
    if settings.feature == "F2":
        return two_distances(settings, point)[1]
    return mostly_near(_near_distance, _distance, settings, point)[0]


def _distance(cells: Cells) -> tuple[Float32, ...]:
    return (smallest(distance(cells.settings, _ways_alone(cells, cells.points()))),)


def two_distances(settings: Settings, point: Point) -> Arrays:
    """(n,) distances of `f1` and of `f2`, whose settings these are."""
    return mostly_near(_near_two_distances, _two_distances, settings, point)


def _two_distances(cells: Cells) -> Arrays:
    return two_smallest(distance(cells.settings, _ways_alone(cells, cells.points())))


def _near_distance(cells: Cells) -> Arrays:
    offset, far = cells.near()
    found = smallest(distance(cells.settings, _ways_alone(cells, cells.points_at(offset))))
    return found, found < far * SURE


def _near_two_distances(cells: Cells) -> Arrays:
    offset, far = cells.near()
    first, second = two_smallest(distance(cells.settings, _ways_alone(cells, cells.points_at(offset))))
    return first, second, second < far * SURE


def smooth_f1(settings: Settings, point: Point) -> Octave:
    """The nearest points blended over `smoothness`."""
    cells = Cells(settings, point, grid_around(point, 5 ** len(point)))
    k = settings.smoothness
    dist: Float32 | None = None
    color = np.zeros((3, cells.local[0].shape[-1]), np.float32)
    place: list[Float32] = [np.zeros(1, np.float32)] * cells.dimension
    for offset, at in cells.around(2):
        d = distance(settings, _ways(cells, at))
        tint = cells.color(offset)
        if dist is None:
            dist, color, place = d, tint, at
            continue
        h = smooth_step(np.clip(np.float32(0.5) + np.float32(0.5) * divide(dist - d, k), 0, 1))
        correction = k * h * (1 - h)
        dist = dist + h * (d - dist) - correction
        correction = correction / (1 + 3 * k)
        color = color + h * (tint - color) - correction
        place = [a + h * (b - a) - correction for a, b in zip(place, at, strict=True)]
    if dist is None:
        raise ValueError("a Voronoi texture has at least one dimension")
    return Octave(dist, color, [p + f for p, f in zip(place, cells.low, strict=True)])


def edge_distance(settings: Settings, point: Point) -> Float32:
    """Euclidean distance to the nearest border between cells."""
    return in_blocks(_edge_distance, settings, point)[0]


def _edge_distance(cells: Cells) -> tuple[Float32, ...]:
    if cells.dimension == 1:
        before, own, after = cells.points()[0]
        sides = [np.abs((own + p) * np.float32(0.5) - cells.local[0]) for p in (before, after)]
        return (np.minimum(*sides),)
    ways = _ways_alone(cells, cells.points())
    nearest = Nearest(sum_of_squares(ways))
    best = nearest.of(ways)
    size, middle = _twice_middle(ways[0], best[0])
    for way, own in zip(ways[1:], best[1:], strict=True):
        for total, part in zip((size, middle), _twice_middle(way, own), strict=True):
            total += part
    # the nearest point has no border with itself; hardly ever another is as near to it as that
    same = nearest.index
    size.reshape(-1)[same] = 1
    if not np.min(size) > NO_BORDER:
        same = np.concatenate([same, others := np.flatnonzero(~(size > NO_BORDER))])
        size.reshape(-1)[others] = 1
    np.sqrt(size, out=size)
    middle *= np.divide(np.float32(0.5), size, out=size)
    middle.reshape(-1)[same] = FAR
    return (smallest(middle),)


def _twice_middle(way: Float32, nearest: Float32) -> tuple[Float32, Float32]:
    """Along an axis (way − nearest)² and, in the memory of the way, (way + nearest)·(way − nearest)."""
    across = way - nearest
    way += nearest
    way *= across
    across *= across
    return across, way


def sphere_radius(settings: Settings, point: Point) -> Float32:
    """Half the distance from the nearest point to its own nearest neighbour."""
    return in_blocks(_sphere_radius, settings, point)[0]


def _sphere_radius(cells: Cells) -> tuple[Float32, ...]:
    points = cells.points()
    nearest = Nearest(sum_of_squares(_ways(cells, points)))
    own = nearest.of(points)
    others = cells.points(nearest.offset(neighbours(cells.dimension)))
    distances = sum_of_squares([p - q for p, q in zip(others, own, strict=True)])
    distances[len(distances) // 2] = FAR  # the point itself
    return (np.sqrt(smallest(distances)) * np.float32(0.5),)
