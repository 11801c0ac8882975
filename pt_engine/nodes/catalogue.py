"""Imports every file that registers node kinds, so that the registry is full before anything is compiled."""

from . import (  # noqa: F401  (their import is what registers the kinds)
    attribute_nodes,
    camera_nodes,
    color_nodes,
    constant_nodes,
    coordinates,
    geometry_nodes,
    image_nodes,
    light_path,
    math_nodes,
    noise_nodes,
    normals,
    object_nodes,
    patterns,
    principled,
    ramps,
    shaders,
    tangents,
    vector_nodes,
    voronoi_nodes,
)
