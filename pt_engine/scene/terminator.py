"""The shadow terminator of smooth meshes: shadow rays that start where the curved surface would be.

Vertex normals light a coarse mesh as if it were round, but its flat triangles still shade each other: where
light grazes, shadows follow the triangles' edges. As in Cycles, a shadow ray that leaves within a cutoff
of the horizon starts above its triangle by

    h = max(½ b, min(h₀, h₁, h₂))        along the interpolated normal,

where b is a parabola that bends away from the corners' tangents, and hᵢ the height of the tangent plane of
corner i over the point, no lower than the triangle. It fades in from the cutoff on:

    share = clamp(2 − (ng·ω + min(n·ω, c)) / c)        c the cutoff, n·ω > 0 for the side that n says

From there, light below the triangle's horizon but above the curved surface's may pass too, so the BSDF is
gated by n instead of ng for emitter samples; without a cutoff too, where such rays start behind their
triangle and only others hide the light. Neither adds energy: visibility stays in [0, 1], so
∫ f |n·ω| V dω ≤ ∫ f |n·ω| dω, the albedo, and weights of combined estimators sum to 1 before it.
Rays that follow the BSDF start and end at the triangles, as in Cycles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..emitters.base import FAR

if TYPE_CHECKING:
    from .scene import Scene
    from .snapshot import Snapshot
    from .surface import Surface

Float32 = NDArray[np.float32]
SMALLEST = 1e-6  # cosine that makes a difference


class Terminator:
    """Which instances' shadow rays start above their triangles; those of all smooth ones follow n.

    Parameters
    ----------
    cutoff : (I,) float32
        Cosine up to which they do; 0 for those whose rays never do, as on flat meshes.
    alone : (I,) bool
        Those whose normals blend in the world (`scene.alone`).
    """

    def __init__(self, cutoff: Float32, alone: NDArray[np.bool_]) -> None:
        self.cutoff = cutoff
        self.alone = alone if alone.any() else None
        self.widest = np.float32(np.max(cutoff))

    @property
    def lifts(self) -> bool:
        """Whether any ray starts above its triangle."""
        return bool(self.widest > 0)

    @classmethod
    def of(cls, snapshot: Snapshot, alone: NDArray[np.bool_]) -> Terminator | None:
        """That of a snapshot; None where nothing is smooth or nobody says. `alone` (I,) is as above."""
        instances = snapshot.instances
        if instances.terminator is None:
            return None
        curved = np.array([mesh.normals is not None for mesh in snapshot.meshes], np.bool_)
        smooth = curved[instances.mesh]
        cutoff = np.where(smooth & (instances.terminator > SMALLEST), instances.terminator, np.float32(0))
        return cls(cutoff, alone) if smooth.any() else None

    def lift(self, scene: Scene, si: Surface, wo: Float32, o: Float32, tfar: Float32) -> Float32:
        """Move the origins `o` of shadow rays where the cutoff says so, and aim at the same points.

        Parameters
        ----------
        wo : (3, N) float32
            Toward the emitters, from `si.p`.
        o : (3, N) float32
            Changed in place, as is `tfar`.
        tfar : (N,) float32
            Length; negative for rays that are not traced, `FAR` or more to what lies at infinity.

        Returns
        -------
        (3, N) float32
            Directions from `o`.
        """
        if not self.lifts:
            return wo
        cos_n = vectors.dot(si.ns, wo)
        side = np.copysign(np.float32(1), cos_n)
        cos_n, cos_g = np.abs(cos_n), vectors.dot(si.ng, wo) * side
        lanes = np.flatnonzero((cos_g + np.minimum(cos_n, self.widest) < 2 * self.widest) & (tfar > 0))
        cutoff = self.cutoff.take(si.take(lanes).instance)
        near = cos_g.take(lanes) + np.minimum(cos_n.take(lanes), cutoff)
        moved = (near < 2 * cutoff) & (cutoff > 0)
        lanes, cutoff, near = lanes[moved], cutoff[moved], near[moved]
        if len(lanes) == 0:
            return wo
        here, outward = si.take(lanes), si.ng.take(lanes, axis=1) * side.take(lanes)
        step = np.clip(2 - near / cutoff, 0, 1) * height(scene, here, outward, self.alone)
        step += here.bound * outward  # also where ω points below: the triangle itself is in the way then
        o[:, lanes] = here.p + step
        return aimed(wo, tfar, lanes, step)


def aimed(wo: Float32, tfar: Float32, lanes: NDArray[np.intp], step: Float32) -> Float32:
    """Directions (3, N) to the same points from origins that have moved by `step`; lengths go to `tfar`."""
    nearby = tfar.take(lanes) < FAR
    lanes, step = lanes[nearby], step[:, nearby]
    if len(lanes) == 0:
        return wo
    to = wo.take(lanes, axis=1) * tfar.take(lanes) - step
    wo = wo.copy()
    wo[:, lanes] = vectors.normalize(to)
    tfar[lanes] = vectors.length(to)
    return wo


def height(scene: Scene, si: Surface, outward: Float32, alone: NDArray[np.bool_] | None) -> Float32:
    """(3, N) from points of triangles to the surface that the corners' normals imply, where it is `outward`.

    Made in object space, of eᵢⱼ = nᵢ·(xⱼ − xᵢ), which is negative where the surface bends away from nᵢ. These
    products are the world's own where an object's normals blend there (`alone`), and its normal is, too.
    """
    prim, instance, b1, b2 = si.prim, si.instance, si.u, si.v
    b0 = 1 - b1 - b2
    assert scene.normals is not None
    x0, x1, x2 = scene.layer("position", "").corners(prim, instance)
    n0, n1, n2 = scene.normals.corners(prim, instance)
    blended = b0 * n0 + b1 * n1 + b2 * n2
    n = scene.transforms.vector_to_world(blended, instance)
    if alone is not None:
        lanes = np.flatnonzero(alone.take(instance))
        n[:, lanes] = scene.transforms.normal_to_world(blended.take(lanes, axis=1), instance.take(lanes))
    side = np.copysign(np.float32(1), vectors.dot(n, outward))  # from inside, the surface bends the other way
    first, second, third = side * (x1 - x0), side * (x2 - x1), side * (x0 - x2)
    e01, e02 = vectors.dot(first, n0), -vectors.dot(third, n0)
    e12, e10 = vectors.dot(second, n1), -vectors.dot(first, n1)
    e20, e21 = vectors.dot(third, n2), -vectors.dot(second, n2)
    parabola = -(e01 + e10) * b0 * b1 - (e12 + e21) * b1 * b2 - (e20 + e02) * b2 * b0
    planes = (
        np.maximum(np.maximum(np.maximum(one, other), 0) - (weight * one + rest * other), 0)
        for one, other, weight, rest in ((e01, e02, b1, b2), (e10, e12, b0, b2), (e20, e21, b0, b1))
    )
    lowest = np.minimum(np.minimum(next(planes), next(planes)), next(planes))
    raised: Float32 = n * (side * np.maximum(lowest, np.float32(0.5) * parabola))
    return raised
