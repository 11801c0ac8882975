"""The bench's models as .blend files and as snapshots: `python -m bench.scenes FOLDER [S1 ...]`.

A process of its own makes them, so that only it needs Blender's memory.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from .shapes import FRAMES, MODELS, Ball, Frame, Model, Part, View

ROOT = Path(__file__).resolve().parents[1]


def made(folder: Path, names: tuple[str, ...] = tuple(MODELS)) -> dict[str, Path]:
    """Paths of the .blend files by name (a .snapshot lies beside each); made where they are missing."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = {name: folder / f"{name}.blend" for name in names}
    missing = [name for name, path in paths.items() if not path.with_suffix(".snapshot").exists()]
    if missing:
        subprocess.run([sys.executable, "-m", "bench.scenes", str(folder), *missing], cwd=ROOT, check=True)
    return paths


def build(model: Model, frame: Frame) -> None:
    """Make the model the current Blender file."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for part in model.parts:
        scene.collection.objects.link(_object(part))
    for ball in model.balls:
        scene.collection.objects.link(_lamp(ball))
    scene.camera = _camera(model.view)
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x, scene.render.resolution_y = frame.width, frame.height
    scene.render.engine = "CYCLES"
    scene.cycles.pixel_filter_type = "BOX"
    _world(scene, model)


def _object(part: Part):
    import bpy

    mesh = bpy.data.meshes.new("part")
    mesh.from_pydata(part.vertices.tolist(), [], part.triangles.tolist())
    material = bpy.data.materials.new("part")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    kind = "ShaderNodeBsdfDiffuse" if part.roughness is None else "ShaderNodeBsdfAnisotropic"
    shader = tree.nodes.new(kind)
    shader.inputs["Color"].default_value = (*part.colour, 1)
    shader.inputs["Roughness"].default_value = part.roughness or 0.0
    if part.roughness is not None:
        shader.distribution = "GGX"
    last = shader
    if part.emission is not None:
        glow, last = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
        glow.inputs["Color"].default_value = (*part.emission, 1)
        tree.links.new(shader.outputs[0], last.inputs[0])
        tree.links.new(glow.outputs[0], last.inputs[1])
    tree.links.new(last.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    mesh.materials.append(material)
    return bpy.data.objects.new("part", mesh)


def _lamp(ball: Ball):
    import bpy

    light = bpy.data.lights.new("ball", "POINT")
    light.energy, light.shadow_soft_size, light.use_soft_falloff = ball.power, ball.radius, False
    lamp = bpy.data.objects.new("ball", light)
    lamp.location = ball.centre
    return lamp


def _camera(view: View):
    import bpy
    from mathutils import Matrix, Vector

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit, camera.data.angle = "HORIZONTAL", view.fov
    camera.data.clip_start, camera.data.clip_end = 0.01, 1000
    back = (Vector(view.eye) - Vector(view.target)).normalized()
    right = Vector(view.up).cross(back).normalized()
    turn = Matrix((right, back.cross(right), back)).transposed().to_4x4()
    camera.matrix_world = Matrix.Translation(view.eye) @ turn
    return camera


def _world(scene, model: Model) -> None:
    import bpy
    import numpy as np

    scene.world = bpy.data.worlds.new("world")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    tree.links.new(background.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    if model.sky is None:
        return
    height, width, _ = model.sky.shape
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    rgba = np.dstack([model.sky[::-1], np.ones((height, width))])
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.file_format = "OPEN_EXR"
    image.pack()
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def main(folder: Path, names: list[str]) -> None:
    """Write NAME.blend and NAME.snapshot for each name."""
    folder.mkdir(parents=True, exist_ok=True)
    import bpy

    from pt_engine.blender.export.scene import export_scene
    from pt_engine.scene.snapshot_io import save_snapshot

    for name in names:
        build(MODELS[name](), FRAMES[name])
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), compress=True)
        save_snapshot(export_scene(bpy.context.evaluated_depsgraph_get()), folder / f"{name}.snapshot")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), sys.argv[2:])
