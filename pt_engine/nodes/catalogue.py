"""Imports every file that registers node kinds, so that the registry is full before anything is compiled."""

from . import (  # noqa: F401  (their import is what registers the kinds)
    color_nodes,
    gabor,
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
