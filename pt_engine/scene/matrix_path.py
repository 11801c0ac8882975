"""Matrices between time steps: taken apart, blended, and put together again.

    M = T · R · S        translation, rotation (unit quaternion w, x, y, z), scale, shear (upper triangular)

T and S are blended linearly, R along the shorter great circle (Shoemake 1985). So a rotation keeps its size
and a mirrored object stays mirrored; it is also how Cycles does it. Where axes have shrunk to nothing, one
takes the direction that the other two leave, and several turn as little as they can from a neighbour step's.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float64 = NDArray[np.float64]

NEARLY_EQUAL = 0.9995  # cosine of quaternions from which on the chord will do for the arc
FLAT = 1e-12  # of its column: what is left beside the axes before is rounding
ALONG = 1e-6  # sine of the angle below which vectors have no plane in common


def step(time: float, steps: int) -> tuple[int, float]:
    """Which of `steps` even times lies before `time` in [0, 1], and how far on the way to the next it is."""
    place = time * (steps - 1)
    first = min(int(place), steps - 2)
    return first, place - first


class MatrixPath(NamedTuple):
    """Matrices of M things at K times, taken apart.

    Attributes
    ----------
    translation : (M, K, 3) float64
    rotation : (M, K, 4) float64
        Unit quaternions, neighbours in the same half space.
    scale : (M, K, 3, 3) float64
    """

    translation: Float64
    rotation: Float64
    scale: Float64

    @classmethod
    def of(cls, matrix: Float64) -> MatrixPath:
        """Take (M, K, 4, 4) matrices apart."""
        linear = matrix[..., :3, :3]
        with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is dropped when it is placed
            axes, scale = orthogonal(linear)
            rotation = quaternion(axes)
        steps = matrix.shape[1]
        for k in range(1, steps):
            away = (rotation[:, k] * rotation[:, k - 1]).sum(axis=-1) < 0
            rotation[away, k] *= -1
        return cls(matrix[..., :3, 3], rotation, scale)

    def at(self, time: float) -> Float64:
        """(M, 4, 4) matrices at a time in [0, 1]."""
        first, part = step(time, self.rotation.shape[1])
        a, b = first, first + 1
        matrix = np.zeros((len(self.rotation), 4, 4))
        with np.errstate(invalid="ignore", over="ignore"):
            turned = as_matrix(arc(self.rotation[:, a], self.rotation[:, b], part))
            matrix[:, :3, :3] = turned @ blend(self.scale[:, a], self.scale[:, b], part)
            matrix[:, :3, 3] = blend(self.translation[:, a], self.translation[:, b], part)
        matrix[:, 3, 3] = 1
        return matrix


def blend(a: Float64, b: Float64, part: float) -> Float64:
    """What lies `part` of the way from a to b."""
    return (1 - part) * a + part * b


def orthogonal(linear: Float64) -> tuple[Float64, Float64]:
    """Right-handed axes (columns) and the upper triangular rest of (M, K, 3, 3) matrices (Gram-Schmidt).

    Twice over, since what rounding leaves of the axes before would be all that is left of a column that lies
    between them; one that does has no length.
    """
    axes, scale = np.zeros(linear.shape), np.zeros(linear.shape)
    for k in range(3):
        column = linear[..., k]
        rest = column
        for j in (*range(k), *range(k)):
            part = dot(axes[..., j], rest)
            scale[..., j, k] += part
            rest = rest - part[..., None] * axes[..., j]
        axis, length = unit(rest)
        kept = ~(length <= FLAT * np.sqrt(dot(column, column)))
        axes[..., k], scale[..., k, k] = axis * kept[..., None], length * kept
    mirrored = np.where(complete(axes) < 0, -1.0, 1.0)[..., None, None]
    return axes * mirrored, scale * mirrored


def complete(axes: Float64) -> Float64:
    """Give (M, K, 3, 3) axes those that are missing, in place, near to a neighbour step's and of its hand.

    Returns
    -------
    (M, K) float64
        1 for right-handed ones, −1 for mirrored ones.
    """
    hand: Float64 = np.sign(np.linalg.det(axes))
    last = axes.shape[1] - 1
    for before, k in [*pairwise(range(last + 1)), *pairwise(range(last, -1, -1))]:
        rows = np.flatnonzero((hand[:, k] == 0) & (np.abs(hand[:, before]) == 1))
        hand[rows, k] = hand[rows, before]
        axes[rows, k] = filled(axes[rows, k], axes[rows, before], hand[rows, k])
    alone = hand == 0
    hand[alone] = 1
    axes[alone] = filled(axes[alone], np.tile(np.eye(3), (int(alone.sum()), 1, 1)), hand[alone])
    return hand


def filled(axes: Float64, like: Float64, hand: Float64) -> Float64:
    """(n, 3, 3) axes with the missing ones (0) made as they are in others, of a `hand` (n,)."""
    known = axes.any(axis=-2)
    axes = np.where(known.any(axis=-1)[:, None, None], axes, like)
    for k in range(3):
        rows = np.flatnonzero(known[:, k] & (known.sum(axis=-1) == 1))
        axes[rows, :, k - 2] = across(axes[rows, :, k], like[rows, :, k - 2])
    for k in range(3):
        rows = np.flatnonzero(~axes.any(axis=-2)[:, k])
        third = np.cross(axes[rows, :, k - 2], axes[rows, :, k - 1])
        axes[rows, :, k] = third * hand[rows, None]
    return axes


def across(v: Float64, near: Float64) -> Float64:
    """(n, 3) unit vectors orthogonal to v, as near as can be to others."""
    found, length = unit(near - dot(v, near)[:, None] * v)
    least = np.eye(3)[np.argmin(np.abs(v), axis=-1)]
    return np.asarray(np.where((length > ALONG)[:, None], found, unit(np.cross(v, least))[0]))


def unit(v: Float64) -> tuple[Float64, Float64]:
    """Vectors (..., 3) at length 1, and their lengths; 0 stays 0."""
    length = np.sqrt(dot(v, v))
    return v / (length + (length == 0))[..., None], length


def dot(a: Float64, b: Float64) -> Float64:
    """(...,) products of vectors (..., n)."""
    product: Float64 = (a * b).sum(axis=-1)
    return product


def quaternion(r: Float64) -> Float64:
    """(..., 4) unit quaternions of rotations: the row of 4 q qᵀ with the largest diagonal, made positive."""
    one = np.ones(r.shape[:-2])
    xx, yy, zz = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    wx, wy, wz = r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]
    xy, xz, yz = r[..., 0, 1] + r[..., 1, 0], r[..., 0, 2] + r[..., 2, 0], r[..., 1, 2] + r[..., 2, 1]
    rows = [
        [one + xx + yy + zz, wx, wy, wz],
        [wx, one + xx - yy - zz, xy, xz],
        [wy, xy, one - xx + yy - zz, yz],
        [wz, xz, yz, one - xx - yy + zz],
    ]
    outer = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    pivot = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(outer, pivot[..., None, None], axis=-2)[..., 0, :]
    q: Float64 = row / np.sqrt(dot(row, row))[..., None]
    return q


def arc(a: Float64, b: Float64, part: float) -> Float64:
    """(M, 4) quaternions `part` of the way from a to b."""
    cosine = dot(a, b)
    chord = blend(a, b, part)
    chord /= np.sqrt(dot(chord, chord))[:, None]
    angle = np.arccos(np.clip(cosine, -1, 1))
    across, _ = unit(b - a * cosine[:, None])
    circle = a * np.cos(part * angle)[:, None] + across * np.sin(part * angle)[:, None]
    return np.where((cosine > NEARLY_EQUAL)[:, None], chord, circle)


def as_matrix(q: Float64) -> Float64:
    """(M, 3, 3) rotations of unit quaternions."""
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
