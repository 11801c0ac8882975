"""Spheres of every closure in a studio, by Cycles and by us: one cell of the picture each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene
from support.cycles import by_cycles, by_engine
from support.ztest import Agreement, compare

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import EXACT
from pt_engine.scene.snapshot import Graph

from .closures import Patch, exported, material, patches
from .measure import worst

CELL = 16  # pixels along a sphere's cell


def chosen() -> list[tuple[Patch, Any]]:
    """A patch, with its material, for each combination of a kind's settings that we say is exact.

    Others would light their neighbours wrongly.
    """
    first: dict[Any, Patch] = {}
    for patch in sorted(patches(), key=lambda patch: patch.inputs != (("Roughness", 0.3),)):
        first.setdefault((patch.kind, patch.settings), patch)
    made = [(patch, material(patch)) for patch in first.values()]
    graphs = exported([one for _, one in made])
    return [pair for pair, graph in zip(made, graphs, strict=True) if is_exact(graph)]


def is_exact(graph: Graph) -> bool:
    """Whether the coverage says so of every node."""
    return worst(compile_materials([graph]).coverage)[0] == EXACT


def mixed(kind: str) -> Any:
    """A Mix or an Add of Diffuse and Glossy."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    node, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for k, part in enumerate(("BsdfDiffuse", "BsdfAnisotropic")):
        closure = tree.nodes.new("ShaderNode" + part)
        closure.inputs["Color"].default_value = (0.3, 0.5 - 0.3 * k, 0.2, 1)
        closure.inputs["Roughness"].default_value = 0.4
        tree.links.new(closure.outputs[0], [s for s in node.inputs if s.type == "SHADER"][k])
    if kind == "MixShader":
        node.inputs["Fac"].default_value = 0.3
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return made


def studio(materials: Sequence[Any]) -> tuple[int, int]:
    """Spheres in a grid before a graded sky, lit by two softboxes, in the empty scene; its size in cells."""
    scene = bpy.context.scene
    columns = math.ceil(math.sqrt(len(materials)))
    rows = math.ceil(len(materials) / columns)
    for k, made in enumerate(materials):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.45)
        owner = bpy.context.object
        owner.location = (k % columns + 0.5, 0.0, rows - k // columns - 0.5)
        owner.data.shade_smooth()
        owner.data.materials.append(made)
    sky = bpy.data.worlds.new("Studio")
    tree = with_nodes(sky)
    coordinates, split = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
    spread, end = tree.nodes.new("ShaderNodeMapRange"), tree.nodes.new("ShaderNodeOutputWorld")
    spread.inputs["From Min"].default_value, spread.inputs["To Min"].default_value = -1.0, 0.1
    background = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(coordinates.outputs["Generated"], split.inputs[0])
    tree.links.new(split.outputs["Z"], spread.inputs["Value"])
    tree.links.new(spread.outputs["Result"], background.inputs["Color"])
    tree.links.new(background.outputs[0], end.inputs["Surface"])
    scene.world = sky
    for x, energy in ((-6, 900), (columns + 6, 400)):
        box = bpy.data.lights.new("Softbox", "AREA")
        box.size, box.energy = 4.0, energy
        lamp = add(box, location=(x, -8, rows + 4))
        lamp.rotation_euler = (math.radians(60), 0, math.radians(-40 if x < 0 else 40))
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", max(columns, rows)
    camera.location, camera.rotation_euler = (columns / 2, -50, rows / 2), (math.pi / 2, 0, 0)
    return columns, rows


def compared(samples: int, folder: Path) -> list[tuple[str, Agreement]]:
    """Name, and agreement of the cell, of every sphere."""
    empty_scene()
    every = chosen()
    materials = [one for _, one in every] + [mixed(k) for k in ("MixShader", "AddShader")]
    columns, rows = studio(materials)
    size = (CELL * columns, CELL * rows)
    ours, theirs = by_engine(samples, size), by_cycles(samples, size, folder)
    names = [patch.name for patch, _ in every] + ["MixShader", "AddShader"]
    found = []
    for k, name in enumerate(names):
        rows_of = slice(k // columns * CELL, (k // columns + 1) * CELL)
        columns_of = slice(k % columns * CELL, (k % columns + 1) * CELL)
        part = [np.ascontiguousarray(image[rows_of, columns_of, :3]) for image in (*ours, *theirs)]
        agreement = compare((part[0], part[1]), (part[2], part[3]), grid=(3, 3))
        found.append((name, agreement))
    return found
