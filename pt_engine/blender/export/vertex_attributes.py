"""Attributes of vertices that Cycles computes from a mesh: Pointiness and Random Per Island.

Pointiness is the angle between a vertex's normal and the mean direction to its neighbours, over π (0.5 where
the surface is flat), then averaged with the neighbours' own. Vertices in the same place count as one.
"""

from __future__ import annotations

import numpy as np

from ...nodes.hashes import UNIT, hash_uints

EPSILON = np.float32(2.0**-23)


def pointiness(positions, normals, edges):
    """(V,) float32.

    Parameters
    ----------
    positions, normals : (V, 3) float32
    edges : (E, 2) int32
    """
    count = len(positions)
    original = welded(positions)
    summed = np.zeros((count, 3), np.float32)
    np.add.at(summed, original, normals)
    normal = unit(summed)[original]
    ends = np.unique(np.sort(original[edges], axis=1), axis=0)
    a, b = ends.T
    along = unit(positions[b] - positions[a])
    toward = np.zeros((count, 3), np.float32)
    np.add.at(toward, a, along)
    np.subtract.at(toward, b, along)
    degree = np.bincount(ends.ravel(), minlength=count).astype(np.float32)
    mean = toward / np.maximum(degree, 1)[:, None]
    angle = np.arccos(np.clip((normal * mean).sum(axis=1), -1, 1)) * np.float32(1 / np.pi)
    raw = angle * (degree > 0)
    blurred = raw.copy()
    np.add.at(blurred, a, raw[b])
    np.add.at(blurred, b, raw[a])
    return (blurred / (degree + 1))[original].astype(np.float32)


def welded(positions):
    """(V,) which vertex stands for each, of those closer than ε½ with x + y + z within 3 ε."""
    total = positions[:, 0] + positions[:, 1] + positions[:, 2]
    order = np.argsort(total, kind="stable")
    place, total = positions[order], total[order]
    parent = np.arange(len(order))
    open_ = np.arange(len(order))
    step = 1
    while len(open_):
        open_ = open_[open_ + step < len(order)]
        open_ = open_[total[open_ + step] - total[open_] <= 3 * EPSILON]
        apart = place[open_ + step] - place[open_]
        same = (apart * apart).sum(axis=1) < EPSILON
        parent[open_[same]] = open_[same] + step
        open_ = open_[~same]
        step += 1
    while (parent[parent] != parent).any():
        parent = parent[parent]
    result = np.empty(len(order), np.intp)
    result[order] = order[parent]
    return result


def unit(v):
    """(V, 3) at unit length; 0 stays 0."""
    length = np.sqrt((v * v).sum(axis=1, keepdims=True))
    return v / (length + (length == 0))


def random_per_island(count: int, edges):
    """(V,) float32 in [0, 1]: a hash of the root of the vertex's island."""
    return (hash_uints(roots(count, edges).astype(np.uint32)) * UNIT).astype(np.float32)


def roots(count: int, edges):
    """(V,) root of each vertex by union by rank, where the edges' order counts: they are taken in turn."""
    parent, rank = list(range(count)), [0] * count
    for a, b in edges.tolist():
        while parent[a] != a:
            parent[a] = a = parent[parent[a]]
        while parent[b] != b:
            parent[b] = b = parent[parent[b]]
        if a == b:
            continue
        if rank[a] < rank[b]:
            a, b = b, a
        parent[b] = a
        rank[a] += rank[a] == rank[b]
    root = np.array(parent, np.intp)
    while (root[root] != root).any():
        root = root[root]
    return root
