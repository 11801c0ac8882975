"""The gallery's six scenes: .blend files for Cycles, snapshots for us, and Mitsuba's form where there is one.

S1, S2, S4    the bench's own (see `shapes`)
demo          the demo's still life: glass, metal, depth of field, a sky (scenes/make_demo.py)
room          a mirror and a glass ball in a grey room under a small lamp: caustics
lamps         the room under forty point lamps
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from .machine import ROOT
from .scenes import made
from .shapes import TITLES


class Shown(NamedTuple):
    """A scene of the gallery: its title, its picture's size, and the longest path in edges."""

    title: str
    width: int
    height: int
    max_depth: int


SHOWN = {
    "S1": Shown(TITLES["S1"], 128, 128, 8),
    "S2": Shown(TITLES["S2"], 192, 108, 5),
    "S4": Shown(TITLES["S4"], 128, 128, 5),
    "demo": Shown("the demo: glass, metal, lens, sky", 192, 108, 8),
    "room": Shown("mirror and glass under a small lamp", 128, 128, 8),
    "lamps": Shown("the same under forty point lamps", 128, 128, 8),
}


def made_all(folder: Path, names: tuple[str, ...] = tuple(SHOWN)) -> dict[str, Path]:
    """Paths of the .blend files by name, each with a .snapshot beside it; made where they are missing."""
    paths = made(folder, tuple(name for name in names if name in TITLES))
    for name in names:
        if name in paths:
            continue
        paths[name] = folder / f"{name}.blend"
        if not paths[name].with_suffix(".snapshot").exists():
            command = [sys.executable, "-m", "bench.gallery_scenes", name, str(paths[name])]
            subprocess.run(command, cwd=ROOT, check=True)
    return paths


def make(name: str, path: Path) -> None:
    """Write one of the scenes that `bench.scenes` does not."""
    if name == "demo":
        subprocess.run([sys.executable, "scenes/make_demo.py", str(path)], cwd=ROOT, check=True)
    import bpy

    from pt_engine.blender.export.scene import export_scene
    from pt_engine.scene.snapshot_io import save_snapshot

    if name == "demo":
        bpy.ops.wm.open_mainfile(filepath=str(path))
        bpy.context.scene.cycles.pixel_filter_type = "BOX"
    else:
        build_room(40 if name == "lamps" else 0)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SHOWN[name].width, SHOWN[name].height
    scene.render.resolution_percentage = 100
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    save_snapshot(export_scene(bpy.context.evaluated_depsgraph_get()), path.with_suffix(".snapshot"))


def build_room(lamps: int) -> None:
    """Five grey walls and two balls; `lamps` points at chance places near the ceiling, or one small lamp."""
    import bpy
    import numpy as np

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.pixel_filter_type = "CYCLES", "BOX"
    grey = material("BsdfDiffuse", (0.7, 0.7, 0.7))
    bpy.ops.mesh.primitive_cube_add(size=4, location=(0, 0, 2))
    box = bpy.context.object
    box.data.materials.append(grey)
    front = max(box.data.polygons, key=lambda face: -face.center[1])
    keep(box.data, [face.index for face in box.data.polygons if face.index != front.index])
    for kind, place in (("BsdfAnisotropic", (-0.85, 0.5, 0.8)), ("BsdfGlass", (0.85, -0.3, 0.8))):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=place, segments=64, ring_count=32)
        bpy.context.object.data.materials.append(material(kind, (0.95, 0.95, 0.95)))
        bpy.ops.object.shade_smooth()
    rng = np.random.default_rng(1)
    for _ in range(lamps):
        x, y, z = rng.uniform((-1.8, -1.8, 3.2), (1.8, 1.8, 3.9))
        point_lamp((x, y, z), 50.0 / lamps, 0.0)
    if not lamps:
        point_lamp((0.0, 0.0, 3.5), 50.0, 0.15)
    bpy.ops.object.camera_add(location=(0, -7.5, 2), rotation=(np.pi / 2, 0, 0))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("dark")
    scene.world.color = (0, 0, 0)


def point_lamp(place: tuple[float, float, float], watts: float, radius: float) -> None:
    """A lamp that shines all around."""
    import bpy

    bpy.ops.object.light_add(type="POINT", location=place)
    bpy.context.object.data.energy, bpy.context.object.data.shadow_soft_size = watts, radius


def keep(mesh, faces: list[int]) -> None:
    """A mesh of only these faces."""
    vertices = [tuple(v.co) for v in mesh.vertices]
    polygons = [tuple(mesh.polygons[k].vertices) for k in faces]
    mesh.clear_geometry()
    mesh.from_pydata(vertices, [], polygons)
    mesh.update()


def material(kind: str, colour: tuple[float, float, float]):
    """A material of one shader, smooth."""
    import bpy

    made_material = bpy.data.materials.new(kind)
    if bpy.app.version < (5, 0, 0):
        made_material.use_nodes = True
    tree = made_material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(f"ShaderNode{kind}")
    shader.inputs["Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = 0.0
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made_material


if __name__ == "__main__":
    make(sys.argv[1], Path(sys.argv[2]).resolve())
