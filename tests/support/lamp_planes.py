"""A white Lambert plane under a lamp, seen from above: its pixels by Cycles and by our light sampling."""

import bpy
import numpy as np
import pytest
from support.exr import pixels

PIXELS, WIDTH = 8, 4.0


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


def cycles(scene, path, seed, samples):
    """(64, 3) radiance of the pixels, row by row from below."""
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.device, settings.samples, settings.seed = "CPU", samples, seed
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
    return pixels(scene.render.filepath)[..., :3].reshape(-1, 3).astype(np.float64)


def ours(lights, side, origin=0.0):
    """Mean and its error (64, 3) from light sampling; places on a jittered grid, so the errors are generous.

    `side`² samples a pixel; `origin` is what the lights' places are relative to.
    """
    rng, samples = np.random.default_rng(1), side * side
    size = PIXELS * PIXELS * samples
    pixel, cell = np.divmod(np.arange(size), samples)
    p = np.zeros((3, size), np.float32)
    p[0] = ((pixel % PIXELS + (cell % side + rng.random(size)) / side) / PIXELS - 0.5) * WIDTH
    p[1] = ((pixel // PIXELS + (cell // side + rng.random(size)) / side) / PIXELS - 0.5) * WIDTH
    up = np.zeros_like(p)
    up[2] = 1.0
    s = lights.sample((p - origin).astype(np.float32), up, rng.random((3, size), np.float32))
    value = (s.weight * (np.maximum(s.wo[2], 0.0) / np.pi)).T.reshape(PIXELS * PIXELS, samples, 3)
    return value.mean(axis=1, dtype=np.float64), value.std(axis=1, dtype=np.float64) / np.sqrt(samples)
