"""What a shader scatters in all, by Cycles and by us: sheets of tilted faces under a white sky.

Each face is one pixel of a parallel camera that looks down; faces tilt from column to column, and face
attributes A, B, C, D feed the shader's inputs. Only the camera sees the sheet, so that its pixels are
directional albedos. Ours are the mean weights that the engine's own sampling gives on the same points.
"""

from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Vector
from scipy.stats import qmc
from support import cycles_nodes
from support.bpy_nodes import with_nodes
from support.bpy_scenes import empty_scene
from support.cycles import by_cycles
from support.node_lanes import NodeLanes

from pt_engine.blender.export.images import ImageTable
from pt_engine.blender.export.materials import export_material
from pt_engine.nodes.compile import compile_materials
from pt_engine.scene.shading import Scattered, SliceBSDF


class Sheet(NamedTuple):
    """Faces in rows and columns: cosines toward the viewer by column, attributes (3, rows · columns).

    `behind`: seen from their back side. `edge`: for what depends on the triangle, only points of one triangle
    are looked at, whose first edge goes along "x" (and down) or "y"; without it pixels cover their faces,
    which leaves less noise.
    """

    cosines: np.ndarray
    table: dict
    behind: bool = False
    edge: str = ""

    @property
    def normals(self):
        """(3, n) float32, on the viewer's side, turned toward +x."""
        rows = len(next(iter(self.table.values()))[0]) // len(self.cosines)
        cos = np.tile(self.cosines, rows)
        return np.stack([np.sqrt(1 - cos * cos), 0 * cos, cos]).astype(np.float32)

    @property
    def size(self):
        """Columns and rows."""
        return len(self.cosines), self.normals.shape[1] // len(self.cosines)

    @property
    def centres(self):
        """(3, n) float32."""
        columns, rows = self.size
        x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
        return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)]).astype(np.float32)


def sheet(cosines, behind=False, edge="", **axes):
    """All pairs of some cosines with rows of attributes, each (rows, 3): `A=`, `B=` …"""
    cosines = np.asarray(cosines, np.float64)
    rows = {k: np.asarray(v, np.float32).reshape(-1, 3) for k, v in axes.items()}
    return Sheet(cosines, {k: np.repeat(v.T, len(cosines), axis=1) for k, v in rows.items()}, behind, edge)


def material(kind, links, **settings):
    """A material whose surface is one shader node; `links` as in `cycles_nodes.feed`."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + kind)
    for key, value in settings.items():
        setattr(node, key, value)
    for socket in node.inputs:
        if socket.identifier in links:
            cycles_nodes.feed(tree, socket, links[socket.identifier])
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def mesh_of(shape):
    """The sheet's faces as a mesh."""
    normal, centre = shape.normals.astype(np.float64), shape.centres.astype(np.float64)
    half_x = 0.5 * np.stack([np.ones(len(normal[0])), 0 * normal[0], -normal[0] / normal[2]])
    half_y = np.array([[0.0], [0.5], [0.0]])
    around = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))
    around = around[1:] if shape.edge == "y" else around[:4]
    corners = [centre + i * half_x + j * half_y for i, j in (around[::-1] if shape.behind else around)]
    points = np.stack(corners, axis=2).reshape(3, -1).T
    data = bpy.data.meshes.new("Sheet")
    data.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 4).tolist())
    for key, values in shape.table.items():
        data.attributes.new(key, "FLOAT_VECTOR", "FACE").data.foreach_set(
            "vector", np.ascontiguousarray(values.T).ravel()
        )
    return data


def scene_of(shape, made, sky):
    """The scene: sheet, camera, a pixel per face, and a sky of some radiance; returns the material."""
    scene = empty_scene()
    made = made()
    scene.world = bpy.data.worlds.new("Sky")
    tree = with_nodes(scene.world)
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (sky, sky, sky, 1)
    tree.links.new(background.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    owner = bpy.data.objects.new("Sheet", mesh_of(shape))
    owner.data.materials.append(made)
    for kind in ("diffuse", "glossy", "transmission", "shadow", "volume_scatter"):
        setattr(owner, f"visible_{kind}", False)
    scene.collection.objects.link(owner)
    columns, rows = shape.size
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", max(columns, rows)
    right, up = {"": (0.0, 0.0), "x": (0.2, -0.2), "y": (0.2, 0.2)}[shape.edge]
    camera.location = (columns / 2 + right, rows / 2 + up, 100)
    scene.cycles.filter_width = 0.01
    scene.cycles.pixel_filter_type = "GAUSSIAN" if shape.edge else "BOX"  # the box is always a pixel wide
    return made


def pixels(shape, samples, folder):
    """(3, n) Cycles' mean picture, face by face."""
    images = by_cycles(samples, shape.size, folder)
    return np.mean(images, axis=0)[::-1, :, :3].reshape(-1, 3).T


def graph_of(made):
    """A material as the snapshot has it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return export_material(made.evaluated_get(depsgraph), ImageTable([]))


def by_cycles_and_us(shape, made, samples, folder, points=1024, emission=False, **lanes):
    """Albedos (3, n) of both, and the material's coverage; `made` makes the material in the new file.

    `emission`: with what the material emits.
    """
    made = scene_of(shape, made, 1.0)
    theirs, graph = pixels(shape, samples, folder), graph_of(made)
    ours = albedos(graph, shape, points, emission, **lanes)
    return theirs, ours, compile_materials([graph]).coverage


def values_by_cycles_and_us(shape, made, direction, folder, **lanes):
    """f·|cosθo| (3, n) of both toward a sun in a world direction (3,): one number, without noise."""
    made = scene_of(shape, made, 0.0)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.angle, sun.energy = 0.0, 1.0
    owner = bpy.data.objects.new("Sun", sun)
    owner.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(owner)
    theirs, graph = pixels(shape, 1, folder), graph_of(made)
    here = lanes_of(shape, 1, lanes)
    wo = np.array(direction, np.float32)[:, np.newaxis] / np.linalg.norm(direction)
    bsdf = SliceBSDF(compile_materials([graph]).batches[0].closures(here), here)
    value, _ = bsdf.eval_pdf(np.repeat(wo, here.n, axis=1).astype(np.float32))
    return theirs, np.broadcast_to(value, theirs.shape), compile_materials([graph]).coverage


def lanes_of(shape, points, given):
    """Lanes on the sheet, `points` on each face; `given` overrides what they know, face by face."""
    n = shape.normals.shape[1]
    up, back = np.zeros((3, n), np.float32), np.full(n, shape.behind, np.float32)
    up[2] = 1
    given = {
        "ng": shape.normals, "ns": shape.normals, "wi": up, "position": shape.centres, "backfacing": back,
    } | given  # fmt: skip
    here = NodeLanes(
        colors={k: np.repeat(v, points, axis=1) for k, v in shape.table.items()},
        **{k: np.repeat(v, points, axis=-1) for k, v in given.items()},
    )
    here.noise = np.random.default_rng(3).integers(0, 2**32, (2, here.n), dtype=np.uint32)
    slope = here.ng[0] / here.ng[2]
    x = np.stack([np.ones_like(slope), np.zeros_like(slope), -slope])
    y = np.repeat(np.array([[0.0], [1.0], [0.0]], np.float32), here.n, axis=1)
    here.edges = lambda: (y, y - x) if shape.edge == "y" else (x, x + y)
    return here


def albedos(graph, shape, points, emission=False, **lanes):
    """(3, n) what the engine scatters in all on the sheet: mean weights over `points` of a Sobol sequence."""
    u = qmc.Sobol(3, seed=2).random(points).T.astype(np.float32).clip(0, 1 - 2**-24)
    here = lanes_of(shape, points, lanes)
    batch = compile_materials([graph]).batches[0]
    out = Scattered(
        np.empty((3, here.n), np.float32), np.empty((3, here.n), np.float32),
        np.empty(here.n, np.float32), np.zeros(here.n, np.uint8),
    )  # fmt: skip
    SliceBSDF(batch.closures(here), here).sample(np.tile(u, here.n // points), out)
    emitted = batch.emission(here) if emission else None
    total = out.weight if emitted is None else out.weight + emitted
    return total.reshape(3, -1, points).mean(axis=2, dtype=np.float64)
