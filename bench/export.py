"""How long Blender's scene takes to become a snapshot, and what it weighs.

    python bench/export.py

A sphere of a million smooth triangles with a UV map, and 10,000 instances made by geometry nodes. Prints a
JSON line for each and a table. Needs the bpy module. The depsgraph is evaluated before the clock starts: the
modifiers' own time is Blender's.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
import tracemalloc
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from pt_engine.blender.export import export_scene

REPEAT = 3


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def textured():
    """A material that reads the UV map."""
    material = bpy.data.materials.new("Textured")
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    links.new(nodes.new("ShaderNodeTexImage").outputs[0], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def million_triangles():
    """One smooth sphere of 1,000,000 triangles."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=1000, ring_count=501)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(textured())


def ten_thousand_instances():
    """A cube on each of 10,000 points."""
    data = bpy.data.meshes.new("Points")
    data.vertices.add(10_000)
    data.vertices.foreach_set("co", np.random.default_rng(0).random(30_000, np.float32) * 100)
    owner = bpy.data.objects.new("Points", data)
    bpy.context.scene.collection.objects.link(owner)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end, place, cube = (
        tree.nodes.new(kind)
        for kind in (
            "NodeGroupInput",
            "NodeGroupOutput",
            "GeometryNodeInstanceOnPoints",
            "GeometryNodeMeshCube",
        )
    )
    tree.links.new(start.outputs[0], place.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], place.inputs["Instance"])
    tree.links.new(place.outputs[0], end.inputs[0])
    owner.modifiers.new("Nodes", "NODES").node_group = tree


def ten_thousand_objects():
    """10,000 objects that share one cube."""
    bpy.ops.mesh.primitive_cube_add()
    data = bpy.context.object.data
    for number in range(9_999):
        owner = bpy.data.objects.new(f"Cube {number}", data)
        owner.location = (number % 100, number // 100, 0)
        bpy.context.scene.collection.objects.link(owner)


def array_bytes(value, seen) -> int:
    """Bytes of all arrays below a dataclass, tuple or dict, each once."""
    if isinstance(value, np.ndarray):
        known = id(value) in seen
        seen.add(id(value))
        return 0 if known else value.nbytes
    if dataclasses.is_dataclass(value):
        value = [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, dict):
        value = list(value.values())
    return sum(array_bytes(item, seen) for item in value) if isinstance(value, list | tuple) else 0


def measure(build) -> dict[str, object]:
    """Best time of a few exports, the arrays' size and the peak of Python's memory."""
    empty_scene()
    build()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    seconds = []
    for _ in range(REPEAT):
        begin = time.perf_counter()
        snapshot = export_scene(depsgraph)
        seconds.append(time.perf_counter() - begin)
    size = array_bytes(snapshot, set())
    del snapshot
    tracemalloc.start()
    snapshot = export_scene(depsgraph)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return {
        "case": build.__name__,
        "seconds": round(min(seconds), 4),
        "first_seconds": round(seconds[0], 4),
        "triangles": sum(len(mesh.triangles) for mesh in snapshot.meshes),
        "meshes": len(snapshot.meshes),
        "instances": len(snapshot.instances.mesh),
        "array_megabytes": round(size / 1e6, 1),
        "peak_megabytes": round(peak / 1e6, 1),
    }


def main() -> None:
    rows = [measure(build) for build in (million_triangles, ten_thousand_instances, ten_thousand_objects)]
    for row in rows:
        print(json.dumps(row))
    width = max(len(name) for name in rows[0])
    for name in rows[0]:
        print(f"{name:>{width}}", *(f"{row[name]!s:>24}" for row in rows))


if __name__ == "__main__":
    main()
