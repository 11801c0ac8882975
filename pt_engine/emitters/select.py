"""Which emitter to sample: in proportion to its power, from one alias table over all of them.

Watts for lamps and triangles; for what lies at infinity, the flux through the scene's cross-section,
π R² · irradiance. A hundredth of the choices goes evenly to all, so that no emitter with power is so
rare that a uniform number of 24 bits could not pick it in its due proportion.
"""

from __future__ import annotations

import numpy as np

from . import area, sun
from .base import Float64, Lamp
from .triangle import TriangleEmitters

EVEN_SHARE = 0.01


def lamp_power(lamp: Lamp, scene_radius: float) -> float:
    """Watts, mean of the colour channels; 0 for a lamp that gives no light."""
    strength = float(np.abs(lamp.strength).mean()) * (lamp.shader.brightness if lamp.shader else 1.0)
    data = lamp.data
    if not (np.isfinite(strength) and np.isfinite(lamp.linear).all() and np.isfinite(lamp.centre).all()):
        return 0.0
    if data.kind == "AREA":
        if not area.has_extent(lamp):
            return 0.0
        return strength if data.normalize else strength * area.area(lamp)
    if data.kind == "SUN":
        alpha = sun.half_angle(lamp)
        solid = np.pi * np.sin(alpha) ** 2 if alpha > 0.0 and not data.normalize else 1.0
        return float(np.pi * scene_radius**2 * strength * solid)
    if data.normalize:
        return strength
    return strength * (4.0 * float(np.pi) * data.radius**2 if data.radius > 0.0 else 4.0)


def triangle_power(triangles: TriangleEmitters) -> Float64:
    """(T,) watts of both sides; a varying emission that is estimated as black counts a little."""
    finite = np.nan_to_num(triangles.radiance.astype(np.float64), posinf=0.0, neginf=0.0)
    radiance: Float64 = np.asarray(np.abs(finite).mean(axis=1))
    floor = 1e-3 * float(np.max(radiance)) if radiance.any() else 1.0
    radiance[triangles.varies] = np.maximum(radiance[triangles.varies], floor)
    return np.asarray(2.0 * np.pi * triangles.areas() * radiance, np.float64)


def probabilities(power: Float64) -> Float64:
    """Of choosing each emitter; 0 only for power 0."""
    shining = power > 0.0
    if not shining.any():
        return np.zeros_like(power)
    even = shining / float(shining.sum())
    return np.asarray((1.0 - EVEN_SHARE) * power / float(power.sum()) + EVEN_SHARE * even, np.float64)
