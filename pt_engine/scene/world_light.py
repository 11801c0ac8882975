"""The world as an emitter: how finely its brightness is tabulated to draw directions from, and its suns.

The radiance itself is never tabulated: too coarse a map costs noise, not truth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from ..core.view import View
from ..emitters.environment import ConstantEnvironment, Environment, EnvironmentMap, texel_directions
from ..emitters.sunny import Disc, SunnyEnvironment, cone_directions
from ..nodes.suns import Sun
from ..nodes.world import WorldProgram
from .arrivals import Arrivals
from .sky_lanes import SkyLanes

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
DEPENDS_ON_BOUNCE = {"bounce_kind", "depth", "transparent_depth"}
COARSEST, FINEST = 512, 2048  # rows that are looked at
LARGEST_MAP = 1024  # rows of the map itself
ROUGH = 0.05  # mean step between texels, in units of the mean: more asks for finer rows
CHUNK = 1 << 16  # directions at once
PROBES = 32  # places along each side of a sun's disc


def environment(world: WorldProgram, view: View) -> Environment | None:
    """The world to sample; None where it is black, or not the same for all rays that scatter toward it."""
    if not world.emits or world.needs & DEPENDS_ON_BOUNCE:
        return None
    if world.constant is not None:
        return ConstantEnvironment(tuple(world.constant))

    def radiance(d: Float32) -> Float32:
        return seen(world, d, view)

    if world.without_suns is None:
        return EnvironmentMap(brightness(world, view), radiance)
    discs = [disc for sun in world.suns if (disc := disc_of(world, sun, view)).irradiance > 0]
    sky = EnvironmentMap(brightness(world.without_suns, view), radiance)
    return SunnyEnvironment(sky, discs, radiance) if discs else sky


def seen(world: WorldProgram, d: Float32, view: View) -> Float32:
    """(3, n) radiance from directions d (3, n), as a diffuse surface sees it."""
    came = Arrivals.by(RayKind.DIFFUSE | RayKind.REFLECTION, d.shape[1])
    return world.emission(SkyLanes(d, came, view))


def brightness(world: WorldProgram, view: View) -> Float64:
    """(H, 2H) mean radiance around texel centres, bottom row first.

    There are at least half as many rows as the world's images have: a look-up in the middle of four texels is
    their mean, so none is missed. They are doubled while neighbours differ much.
    """
    limit = FINEST
    if world.image_rows:
        limit = int(min(max(2 ** np.ceil(np.log2(world.image_rows)), COARSEST), FINEST))
    height = COARSEST
    while height < min(world.image_rows // 2, FINEST):
        height *= 2
    image = tabulated(world, height, view)
    while height < limit and roughness(image) > ROUGH:
        height *= 2
        image = tabulated(world, height, view)
    while len(image) > LARGEST_MAP:
        image = image.reshape(len(image) // 2, 2, -1, 2).mean(axis=(1, 3))
    return image


def tabulated(world: WorldProgram, height: int, view: View) -> Float64:
    """(height, 2·height) grey radiance at texel centres."""
    d = texel_directions(height, 2 * height)
    parts = np.array_split(d, max(d.shape[1] // CHUNK, 1), axis=1)
    grey = [seen(world, np.ascontiguousarray(part), view).mean(axis=0, dtype=np.float64) for part in parts]
    image = np.concatenate(grey).reshape(height, 2 * height)
    return np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0).clip(0.0)


def roughness(image: Float64) -> float:
    """Mean difference of texels from the mean of their two neighbours in a row, per mean radiance."""
    height = len(image)
    area = np.sin(np.pi * (np.arange(height) + 0.5) / height)
    step = np.abs(image - 0.5 * (np.roll(image, 1, axis=1) + np.roll(image, -1, axis=1))).sum(axis=1)
    total = float((image.sum(axis=1) * area).sum())
    return float((step * area).sum()) / total if total > 0 else 0.0


def disc_of(world: WorldProgram, sun: Sun, view: View) -> Disc:
    """A sun with what it adds to the sky behind it, from a grid of directions across its disc."""
    u, v = np.divmod(np.arange(PROBES * PROBES), PROBES)
    u, v = ((a + 0.5) / PROBES for a in (u, v))
    d = cone_directions(sun.toward, sun.half_angle, u.astype(np.float32), v.astype(np.float32))
    light = seen(world, d, view).mean(dtype=np.float64)
    if world.without_suns is not None:
        light -= seen(world.without_suns, d, view).mean(dtype=np.float64)
    solid_angle = 4.0 * np.pi * np.sin(0.5 * sun.half_angle) ** 2
    return Disc(sun.toward, sun.half_angle, max(float(light), 0.0) * solid_angle)
