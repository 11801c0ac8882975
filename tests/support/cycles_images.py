"""Cycles' own answer for image textures: sheets of faces (see `cycles_nodes`) that look images up."""

from typing import NamedTuple

import bpy
import numpy as np
from support import cycles_nodes
from support.node_lanes import NodeLanes

from pt_engine.blender.export.images import ImageTable, ocio_config
from pt_engine.blender.export.materials import export_material
from pt_engine.nodes.compile import compile_materials


class Case(NamedTuple):
    """An image, made by `image()` or by a setting, and how a node looks it up.

    `bounds` are those of the random coordinates, `output` is Color or Alpha; `both`: Color · (Alpha + ½).
    `jumps` is the share of look-ups that may differ.
    """

    name: str
    image: object
    settings: dict
    output: str = "Color"
    both: bool = False
    bounds: tuple = (-2.0, 2.0)
    jumps: float = 0.0


def material(case):
    """A material that shines with a case's output."""
    made = cycles_nodes.material(case.name, "TexImage", case.settings, {"Vector": "A"}, case.output)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    node = next(n for n in nodes if n.bl_idname == "ShaderNodeTexImage")
    if case.image is not None:
        node.image = case.image()
    if case.both:
        shine = next(n for n in nodes if n.bl_idname == "ShaderNodeEmission")
        more = nodes.new("ShaderNodeMath")
        more.operation, more.inputs[1].default_value = "ADD", 0.5
        links.new(node.outputs["Alpha"], more.inputs[0])
        links.new(more.outputs[0], shine.inputs["Strength"])
    return made


def answers(cases, frame=1, sheet=cycles_nodes.sheet, lanes=NodeLanes):
    """[(theirs, ours), ...], each (3, n), of all cases; and what our compiler and our export list."""
    bpy.context.scene.frame_set(frame)
    tables, materials = [], []
    for number, case in enumerate(cases):
        table = cycles_nodes.inputs(number, *case.bounds)
        owner = sheet(case.name, table, *cycles_nodes.place(number, len(cases)))
        made = material(case)
        owner.data.materials.append(made)
        tables.append(table)
        materials.append(made)
    picture = cycles_nodes.render(len(cases))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([], frame)
    graphs = [export_material(m.evaluated_get(depsgraph), images) for m in materials]
    ready = compile_materials(graphs, images.images, ocio_config())
    found = []
    for number in range(len(cases)):
        batch = ready.batches[ready.batch_of[number]]
        ours = batch.emission(lanes(colors=tables[number], material=number))
        theirs = cycles_nodes.cut(picture, number, len(cases))
        ours = np.zeros((3, 1), np.float32) if ours is None else ours
        found.append((theirs, np.broadcast_to(ours, theirs.shape)))
    return found, ready.coverage, images.unsupported


def wrong(theirs, ours):
    """(share of pixels that differ by more than 1e-4·(|theirs| + 0.01), a description of the worst)."""
    error = np.abs(ours - theirs) / (np.abs(theirs) + 0.01)
    bad = ~(error <= 1e-4).all(axis=0)
    worst = int(np.nan_to_num(error, nan=np.inf).max(axis=0).argmax())
    text = f"{bad.sum()} of {bad.size} differ, worst {error[:, worst].max():.2g}: {ours[:, worst]} for "
    return bad.mean(), text + f"{theirs[:, worst]}"
