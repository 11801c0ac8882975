"""The Bevel node: normals of the lane's own object nearby, averaged as King et al. gather subsurface light.

Points are drawn on a disk about one of three axes (King et al. 2013, "BSSRDF Importance Sampling"): the
normal half of the time, else a tangent; at distance r with the density of a planar cubic,

    p(r) = 10 (R − r)³ / (π R⁵),        10 x² − 20 x³ + 15 x⁴ − 4 x⁵ = ξ,    x = r/R

and a ray through the ball of radius R meets the surface there. Each hit counts p(|x − hit|)/p(r) times the
power heuristic's weight of its axis.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import keyed, vectors
from ..core.clock import stage
from .moved import tangents
from .tracing import own_hits

if TYPE_CHECKING:
    from .lanes import Lanes
    from .surface import Surface

Float32 = NDArray[np.float32]

NEWTON_STEPS = 10
BLURRED = np.float32(
    8
)  # sr⁻¹: after a bounce of smaller density nobody sees the bevel, so Cycles leaves it out


@stage("", "rays from shading")
def bevelled(lanes: Lanes, radius: Float32, samples: int, key: int, surface: Float32) -> Float32:
    """(3, n) unit normals, on the viewer's side; the `surface`'s where nothing is to be bevelled."""
    noise = lanes.noise
    reach = np.broadcast_to(radius, lanes.n).astype(np.float32)
    round_ = reach > 0
    if lanes.sharpness is not None:
        round_ &= lanes.sharpness >= BLURRED
    if noise is None or samples < 1 or not round_.any():
        return surface
    shift = keyed.bits(noise, key)
    total = np.zeros((3, lanes.n), np.float32)
    for number in range(samples):
        _gather(lanes, keyed.uniforms(shift, number), reach, round_, total)
    size = vectors.length(total)
    found = (size > 0).astype(np.float32)
    total *= (found * (1 - 2 * lanes.backfacing)) / (size + (1 - found))
    return total + (1 - found) * surface


def _gather(lanes: Lanes, u: Float32, radius: Float32, round_: NDArray[np.bool_], total: Float32) -> None:
    """Add what one sample per lane finds to `total`."""
    axes, chances, u_angle = _axes(lanes.ng, u[0])
    r = cubic_root(u[1]) * radius
    height = np.sqrt(np.maximum(radius * radius - r * r, 0))
    angle = np.float32(2 * np.pi) * u_angle
    on_disk = (r * np.cos(angle)) * axes[1] + (r * np.sin(angle)) * axes[2]
    o = lanes.p + axes[0] * height + on_disk
    tfar = np.where(round_, 2 * height, np.float32(-1))
    rest = np.maximum(radius - r, np.float32(1e-20))
    for index, si in own_hits(lanes, o, -axes[0], tfar):
        own_face = si.ng * np.copysign(np.float32(1), si.facing)
        density = [
            c.take(index) * np.abs(vectors.dot(a.take(index, axis=1), own_face))
            for a, c in zip(axes, chances, strict=True)
        ]
        squares = density[0] ** 2 + density[1] ** 2 + density[2] ** 2
        weight = density[0] / np.maximum(squares, np.float32(1e-20))
        distance = vectors.length(si.p - lanes.p.take(index, axis=1))
        weight *= (np.maximum(radius.take(index) - distance, 0) / rest.take(index)) ** 3
        total[:, index] += weight * _shading_normal(lanes, si, own_face)


def _axes(normal: Float32, u: Float32) -> tuple[list[Float32], list[Float32], Float32]:
    """The disk's axis and its tangents, the chance of each to be the axis, and what is left of u.

    The axis is the normal for u < ½, the first tangent for u < ¾, else the second.
    """
    s, t = tangents(normal)
    first, second = (u >= 0.5) & (u < 0.75), u >= 0.75
    axis = np.where(first, s, np.where(second, t, normal))
    along_s, along_t = np.where(first, normal, s), np.where(second, normal, t)
    quarter, half = np.float32(0.25), np.float32(0.5)
    chances = [
        np.where(u < 0.5, half, quarter),
        np.where(first, half, quarter),
        np.where(second, half, quarter),
    ]
    left = np.where(u < 0.5, 2 * u, np.where(first, 4 * u - 2, 4 * u - 3))
    return [axis, along_s, along_t], chances, left


def cubic_root(xi: Float32) -> Float32:
    """x in [0, 1] with 10 x² − 20 x³ + 15 x⁴ − 4 x⁵ = ξ, by Newton's steps from ¼."""
    x = np.full_like(xi, 0.25)
    for _ in range(NEWTON_STEPS):
        x2 = x * x
        value = x2 * (10 + x * (-20 + x * (15 - 4 * x))) - xi
        slope = 20 * x * (1 - x) ** 3
        x = np.clip(x - value * (slope > 0) / (slope + (slope == 0)), 0, 1)
    return x


def _shading_normal(lanes: Lanes, si: Surface, face: Float32) -> Float32:
    """Unit shading normals of hits, on the faces' own sides."""
    normals = lanes.scene.normals
    if normals is None or not lanes.smooth:
        return face
    smooth = lanes.scene.geometry.surface_smooth.take(si.surface)
    n = lanes.scene.transforms.normal_to_world(normals.at(si.prim, si.instance, si.u, si.v), si.instance)
    return np.where(smooth, vectors.normalize(n), face)
