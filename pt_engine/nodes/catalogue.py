"""Imports every file that registers node kinds, so that the registry is full before anything is compiled."""

from __future__ import annotations

from . import (
    color_nodes,
    image_nodes,
    inputs,
    math_nodes,
    noise_nodes,
    normals,
    patterns,
    principled,
    ramps,
    shaders,
    vector_nodes,
    voronoi_nodes,
)
from .registry import NODES, SHADERS

FAMILIES = (
    color_nodes,
    image_nodes,
    inputs,
    math_nodes,
    noise_nodes,
    normals,
    patterns,
    principled,
    ramps,
    shaders,
    vector_nodes,
    voronoi_nodes,
)


def known_kinds() -> frozenset[str]:
    """Every node kind that is understood."""
    return frozenset(NODES) | frozenset(SHADERS)
