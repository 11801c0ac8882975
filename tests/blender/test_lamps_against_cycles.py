"""Lamps in Blender's units: a white Lambert plane under each, rendered by Cycles and by light sampling.

Both estimate the mean radiance E/π of the same 8 × 8 orthographic pixels, direct light alone. Cycles gives
no variance, so two seeds of it do, pooled over the pixels.
"""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import export  # noqa: E402
from support.lamp_planes import cycles, hang, ours, plane_under_a_camera  # noqa: E402
from support.lamps import lights  # noqa: E402

CYCLES_SAMPLES, SIDE = 4096, 90

SPOT = {"type": "SPOT", "energy": 100.0, "spot_size": 1.2, "shadow_soft_size": 0.0}
AREA = {"type": "AREA", "energy": 100.0, "size": 1.5}
RECTANGLE = {**AREA, "shape": "RECTANGLE", "size_y": 0.5}
POINT = {"type": "POINT", "energy": 100.0, "shadow_soft_size": 0.0, "use_soft_falloff": False}
SUN = {"type": "SUN", "energy": 3.0}
SPREAD = {"spread": math.radians(60)}
HARD = {"use_soft_falloff": False}

CASES = {
    "point": POINT,
    "point, not normalised": {**POINT, "normalize": False},
    "sphere": {**POINT, "shadow_soft_size": 0.5},
    "large sphere": {**POINT, "shadow_soft_size": 1.5},
    "sphere, not normalised": {**POINT, "shadow_soft_size": 0.5, "normalize": False},
    "sphere with exposure": {**POINT, "shadow_soft_size": 0.5, "exposure": 1.5},
    "soft falloff": {**POINT, "shadow_soft_size": 1.0, "use_soft_falloff": True},
    "coloured by temperature": {**POINT, "use_temperature": True, "temperature": 3000.0},
    "spot": {**SPOT, "spot_blend": 0.6},
    "spot without blend": {**SPOT, "spot_blend": 0.0},
    "sphere spot": {**SPOT, **HARD, "spot_blend": 0.3, "shadow_soft_size": 0.4},
    "wide sphere spot": {**SPOT, **HARD, "spot_size": 0.5, "spot_blend": 0.3, "shadow_soft_size": 1.5},
    "soft spot": {**SPOT, "spot_blend": 0.3, "shadow_soft_size": 0.4, "use_soft_falloff": True},
    "stretched spot": {**SPOT, **HARD, "spot_blend": 0.5, "shadow_soft_size": 0.2, "scale": (2, 0.5, 1.2)},
    "sun": {**SUN, "angle": 0.0},
    "wide sun": {**SUN, "angle": 0.5},
    "sun, not normalised": {**SUN, "angle": 0.3, "normalize": False},
    "square": {**AREA, "shape": "SQUARE"},
    "rectangle": RECTANGLE,
    "disk": {**AREA, "shape": "DISK"},
    "ellipse": {**RECTANGLE, "shape": "ELLIPSE"},
    "square with spread": {**AREA, "shape": "SQUARE", **SPREAD},
    "rectangle with spread": {**RECTANGLE, **SPREAD},
    "disk with spread": {**AREA, "shape": "DISK", **SPREAD},
    "ellipse with spread": {**RECTANGLE, "shape": "ELLIPSE", **SPREAD},
    "disk with little spread": {**AREA, "shape": "DISK", "spread": math.radians(3)},
    "rectangle without spread": {**RECTANGLE, "spread": 0.0},
    "rectangle, not normalised": {**RECTANGLE, "normalize": False},
    "disk, not normalised": {**AREA, "shape": "DISK", "normalize": False},
    "scaled and mirrored rectangle": {**RECTANGLE, "scale": (2.0, -0.7, 1.5)},
    "scaled ellipse with spread": {**RECTANGLE, "shape": "ELLIPSE", **SPREAD, "scale": (2.0, 0.7, 1.5)},
}


@pytest.mark.parametrize("name", CASES)
def test_lamp(name, tmp_path):
    """The image's mean within 5 standard errors and 3e-4; every pixel within 6 and 1e-3 of the mean."""
    scene = plane_under_a_camera()
    hang(scene, CASES[name])
    renders = np.stack([cycles(scene, tmp_path, seed, CYCLES_SAMPLES) for seed in (1, 2)])
    expected, spread = renders.mean(axis=0), float(np.sqrt(((renders[0] - renders[1]) ** 2).mean()) / 2.0)
    (lamp,) = export().lights
    value, error = ours(lights(lamp), SIDE)
    assert expected.mean() > 0.01
    of_mean = np.hypot(np.sqrt((error**2).sum()) / error.size, spread / np.sqrt(error.size))
    assert abs(value.mean() - expected.mean()) < 5.0 * of_mean + 3e-4 * expected.mean()
    of_pixels = np.hypot(error, spread + 0.01 * error.mean())
    np.testing.assert_array_less(np.abs(value - expected), 6.0 * of_pixels + 1e-3 * expected.mean())
