"""Lamps in Blender's units: a white Lambert plane under each, rendered by Cycles and by light sampling.

Both estimate the mean radiance E/π of the same 8 × 8 orthographic pixels, direct light alone. Cycles gives
no variance, so two seeds of it do, pooled over the pixels.
"""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import export  # noqa: E402
from support.lamps import lights  # noqa: E402

PIXELS, WIDTH = 8, 4.0
CYCLES_SAMPLES, OUR_SAMPLES = 4096, 90 * 90

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


def plane_under_a_camera():
    """An empty file with a white Lambert plane seen from above."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new("white")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs[0].default_value = (1, 1, 1, 1)
    diffuse.inputs[1].default_value = 0
    tree.links.new(diffuse.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("plane", mesh))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", WIDTH
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 20)
    scene.collection.objects.link(scene.camera)
    return scene


def hang(scene, settings):
    """The lamp of a case, tilted, above the plane."""
    from mathutils import Euler, Matrix, Vector

    settings = dict(settings)
    scale = settings.pop("scale", (1, 1, 1))
    data = bpy.data.lights.new("lamp", settings.pop("type"))
    for name, value in settings.items():
        if not hasattr(data, name):
            pytest.skip(f"this Blender has no Light.{name}")
        setattr(data, name, value)
    lamp = bpy.data.objects.new("lamp", data)
    lamp.matrix_world = Matrix.LocRotScale(Vector((0.3, -0.2, 2.0)), Euler((0.3, 0.4, 0.5)), Vector(scale))
    scene.collection.objects.link(lamp)
    bpy.context.view_layer.update()


def cycles(scene, path, seed):
    """(64, 3) radiance of the pixels, row by row from below."""
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.device, settings.samples, settings.seed = "CPU", CYCLES_SAMPLES, seed
    settings.use_adaptive_sampling = settings.use_denoising = settings.use_light_tree = False
    settings.max_bounces = 0
    settings.sample_clamp_direct = settings.light_sampling_threshold = 0.0
    settings.pixel_filter_type = "BOX"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(PIXELS * PIXELS * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)[:, :3].astype(np.float64)


def ours(lamp):
    """The same from light sampling; places on a jittered grid, so the standard errors are generous."""
    scene, rng = lights(lamp), np.random.default_rng(1)
    size, side = PIXELS * PIXELS * OUR_SAMPLES, round(OUR_SAMPLES**0.5)
    pixel, cell = np.divmod(np.arange(size), OUR_SAMPLES)
    p = np.zeros((3, size), np.float32)
    p[0] = ((pixel % PIXELS + (cell % side + rng.random(size)) / side) / PIXELS - 0.5) * WIDTH
    p[1] = ((pixel // PIXELS + (cell // side + rng.random(size)) / side) / PIXELS - 0.5) * WIDTH
    up = np.zeros_like(p)
    up[2] = 1.0
    s = scene.sample(p, up, rng.random((3, size), np.float32))
    value = (s.weight * (np.maximum(s.wo[2], 0.0) / np.pi)).T.reshape(PIXELS * PIXELS, OUR_SAMPLES, 3)
    return value.mean(axis=1, dtype=np.float64), value.std(axis=1, dtype=np.float64) / np.sqrt(OUR_SAMPLES)


@pytest.mark.parametrize("name", CASES)
def test_lamp(name, tmp_path):
    """The image's mean within 5 standard errors and 3e-4; every pixel within 6 and 1e-3 of the mean."""
    scene = plane_under_a_camera()
    hang(scene, CASES[name])
    renders = np.stack([cycles(scene, tmp_path, seed) for seed in (1, 2)])
    expected, spread = renders.mean(axis=0), float(np.sqrt(((renders[0] - renders[1]) ** 2).mean()) / 2.0)
    (lamp,) = export().lights
    value, error = ours(lamp)
    assert expected.mean() > 0.01
    of_mean = np.hypot(np.sqrt((error**2).sum()) / error.size, spread / np.sqrt(error.size))
    assert abs(value.mean() - expected.mean()) < 5.0 * of_mean + 3e-4 * expected.mean()
    of_pixels = np.hypot(error, spread + 0.01 * error.mean())
    np.testing.assert_array_less(np.abs(value - expected), 6.0 * of_pixels + 1e-3 * expected.mean())
