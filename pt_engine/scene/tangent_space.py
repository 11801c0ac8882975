"""MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"): tangents of triangle corners.

Corners with equal position, normal and uv are one vertex. Around each vertex, triangles that hang together by
edges and whose maps have the same handedness form a group; its tangent is the mean of their directions of
growing u, each in the plane of the vertex's normal and weighted by the triangle's angle there. A triangle
whose map has no area joins the first group it touches and adds nothing; one whose corners coincide takes what
another triangle has at the same vertex.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Index = NDArray[np.intp]
Bool = NDArray[np.bool_]

TINY = np.finfo(np.float32).tiny
MIX = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits without a pattern: 2⁶⁴ over the golden ratio


class Faces(NamedTuple):
    """What is known of T triangles before they are grouped.

    Attributes
    ----------
    vertex : (T, 3) intp
        Welded vertex of each corner.
    tangent : (T, 3) float32
        Unit direction of growing u.
    mapped : (T,) bool
        Whether the map has an area.
    upright : (T,) bool
        Whether the map is not mirrored.
    """

    vertex: Index
    tangent: Float32
    mapped: Bool
    upright: Bool


def tangent_space(
    points: Float32, normals: Float32, uv: Float32, around: bool = False
) -> tuple[Float32, Float32]:
    """Tangents of all corners and the signs of their bitangents, sign · n × t.

    Parameters
    ----------
    points, normals : (T, 3, 3) float32
        By triangle and corner.
    uv : (T, 3, 2) float32
    around : bool
        Whether u goes round from 1 to 0: a triangle across the seam lies on the short way.

    Returns
    -------
    tangent : (T, 3, 3) float32
    sign : (T, 3) float32
    """
    count = len(points)
    vertex = welded(np.concatenate([points, normals, uv], axis=2).reshape(3 * count, 8)).reshape(count, 3)
    tangent = np.zeros((count, 3, 3), np.float32)
    tangent[..., 0] = 1
    upright = np.zeros((count, 3), bool)
    whole = ~((points == np.roll(points, 1, axis=1)).all(axis=2).any(axis=1))
    good = np.flatnonzero(whole)
    if len(good):
        there = nearest_turns(uv[good]) if around else uv[good]
        faces = mapped_faces(points[good], there, vertex[good])
        faces, group = grouped(faces)
        directions, angles = at_corners(points[good], normals[good], faces)
        mean = np.zeros((3 * len(good), 3), np.float32)
        used = (group >= 0) & np.repeat(faces.mapped, 3)
        np.add.at(mean, group[used], (directions * angles[..., None]).reshape(-1, 3)[used])
        inside = (group >= 0).reshape(-1, 3)
        tangent[good] = np.where(inside[..., None], unit(mean)[group].reshape(-1, 3, 3), tangent[good])
        upright[good] = inside & faces.upright[:, None]
        borrow(vertex, whole, tangent, upright)
    return tangent, np.where(upright, np.float32(1), np.float32(-1))


def welded(rows: Float32) -> Index:
    """(N,) equal numbers for rows of (N, C) with equal bits, by a 64-bit hash; −0 is not 0 here."""
    bits = np.ascontiguousarray(rows).view(np.uint32)
    key = np.zeros(len(rows), np.uint64)
    for column in bits.T:
        key = (key ^ column) * MIX
        key ^= key >> np.uint64(29)
    return np.unique(key, return_inverse=True)[1]


def nearest_turns(uv: Float32) -> Float32:
    """The map with each u moved by a whole number to within half a turn of its triangle's first."""
    moved = uv.copy()
    moved[..., 0] -= np.floor(uv[..., 0] - uv[:, :1, 0] + np.float32(0.5))
    return moved


def mapped_faces(points: Float32, uv: Float32, vertex: Index) -> Faces:
    """Mikkelsen's equation 18: ∂p/∂u ∝ v₃₁ p₂₁ − v₂₁ p₃₁."""
    d1, d2 = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    t1, t2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = t1[:, 0] * t2[:, 1] - t1[:, 1] * t2[:, 0]
    along_u = t2[:, 1:] * d1 - t1[:, 1:] * d2
    along_v = t1[:, :1] * d2 - t2[:, :1] * d1
    squares = [(w * w).sum(axis=1) for w in (along_u, along_v)]
    mapped = (np.abs(area) > TINY) & (squares[0] > TINY) & (squares[1] > TINY)
    upright = area > 0
    turned = unit(along_u) * np.where(upright, np.float32(1), np.float32(-1))[:, None]
    return Faces(vertex, turned * (np.abs(area) > TINY)[:, None], mapped, upright)


def grouped(faces: Faces) -> tuple[Faces, Index]:
    """The faces, those without a map now as upright as what they join, and each corner's group (−1: none).

    A group is named by its first corner.
    """
    a, b = shared_corners(faces.vertex)
    corners = faces.vertex.size
    upright, decided = faces.upright.copy(), faces.mapped.copy()
    group = np.where(np.repeat(decided, 3), np.arange(corners), corners)
    while True:
        f, g = a // 3, b // 3
        link = decided[f] & decided[g] & (upright[f] == upright[g])
        group = connected(group, a[link], b[link])
        # the first group that an unmapped face touches decides
        pairs = np.concatenate([np.stack([a, b]), np.stack([b, a])], axis=1)
        touched = pairs[:, ~decided[pairs[0] // 3] & (group[pairs[1]] < corners)]
        if touched.shape[1] == 0:
            return faces._replace(upright=upright), np.where(group < corners, group, -1)
        first = np.full(len(upright), corners)
        np.minimum.at(first, touched[0] // 3, group[touched[1]])
        new = np.flatnonzero(first < corners)
        upright[new], decided[new] = upright[first[new] // 3], True


def shared_corners(vertex: Index) -> tuple[Index, Index]:
    """Corners that neighbouring triangles have in common, as pairs.

    Neighbours run along an edge in opposite directions; of several at an edge the first one way belongs to
    the first the other way, and so on.
    """
    start, end = vertex.ravel(), np.roll(vertex, -1, axis=1).ravel()
    key: Index = np.minimum(start, end) * (int(np.max(vertex)) + 1) + np.maximum(start, end)
    forward = start < end
    one, other = np.flatnonzero(forward), np.flatnonzero(~forward)
    one, other = one[np.argsort(key[one], kind="stable")], other[np.argsort(key[other], kind="stable")]
    left, right = ranked(key[one]), ranked(key[other])
    _, i, j = np.intersect1d(left, right, assume_unique=True, return_indices=True)
    e, f = one[i], other[j]
    return np.concatenate([e, following(e)]), np.concatenate([following(f), f])


def ranked(key: Index) -> NDArray[np.void]:
    """(N,) pairs of a sorted key and the number of equal ones before it."""
    first = np.concatenate([[True], key[1:] != key[:-1]])
    place = np.arange(len(key))
    pair = np.empty(len(key), [("key", key.dtype), ("rank", place.dtype)])
    pair["key"], pair["rank"] = key, place - np.maximum.accumulate(np.where(first, place, 0))
    return pair


def following(corner: Index) -> Index:
    """The next corner of the same triangle."""
    return np.where(corner % 3 == 2, corner - 2, corner + 1)


def connected(label: Index, a: Index, b: Index) -> Index:
    """Labels lowered to the least of all that are linked by pairs (a, b); len(label) is none yet."""
    label = label.copy()
    while True:
        before = label.copy()
        low = np.minimum(before[a], before[b])
        for end in (a, b):
            np.minimum.at(label, end, low)
            rooted = before[end] < len(label)
            np.minimum.at(label, before[end][rooted], low[rooted])
        inside = np.flatnonzero(label < len(label))
        label[inside] = label[label[inside]]
        if np.array_equal(label, before):
            return label


def face_normals(points: Float32) -> Float32:
    """(T, 3) unit normals of (T, 3, 3) corners; each product is rounded, so that zeros have Cycles' signs."""
    a, b = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    axes = ((1, 2), (2, 0), (0, 1))
    return unit(np.stack([a[:, i] * b[:, j] - a[:, j] * b[:, i] for i, j in axes], axis=1))


def at_corners(points: Float32, normals: Float32, faces: Faces) -> tuple[Float32, Float32]:
    """Each face's tangent in the planes of its corners' normals (T, 3, 3), and its angles there (T, 3)."""
    onward, back = np.roll(points, -1, axis=1) - points, np.roll(points, 1, axis=1) - points
    along, across = in_plane(normals, onward), in_plane(normals, back)
    angle: Float32 = np.arccos(np.clip((along * across).sum(axis=2), -1, 1))
    return in_plane(normals, np.broadcast_to(faces.tangent[:, None], normals.shape)), angle


def in_plane(n: Float32, v: Float32) -> Float32:
    """The part of v across n, unit length."""
    return unit(v - n * (n * v).sum(axis=2, keepdims=True))


def unit(v: Float32) -> Float32:
    """Unit length along the last axis; 0 stays 0."""
    length: Float32 = np.sqrt((v * v).sum(axis=-1, keepdims=True))
    scaled: Float32 = v / (length + (length == 0))
    return scaled


def borrow(vertex: Index, whole: Bool, tangent: Float32, upright: Bool) -> None:
    """Give the corners of collapsed triangles what the first whole one has at the same vertex."""
    broken = np.flatnonzero(~whole)
    if len(broken) == 0:
        return
    lender = np.full(int(np.max(vertex)) + 1, -1)
    corners = (3 * np.flatnonzero(whole)[:, None] + np.arange(3)).ravel()[::-1]
    lender[vertex.ravel()[corners]] = corners  # the first comes last and stays
    source = lender[vertex[broken]]
    found = source >= 0
    tangent[broken] = np.where(found[..., None], tangent.reshape(-1, 3)[source], tangent[broken])
    upright[broken] = np.where(found, upright.ravel()[source], upright[broken])
