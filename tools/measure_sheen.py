"""Makes `pt_engine/bsdfs/sheen.npz`: the sheen layer's lobe and albedo, measured in Cycles.

    python tools/measure_sheen.py            (a Python that has the bpy module)

Cycles' microfiber sheen (Zeltner, Burley and Chiang 2022) is a cosine lobe bent by a matrix, times an albedo:

    f·cosθo = R/π z (a/l²)²,   l² = (a x + b z)² + (a y)² + z²,   (x, y, z) = wo, x toward the viewer's side

with a, b and R in tables of 32 roughnesses × 32 cosines θi, linear between. A lamp of no size lights a
surface without noise, so the radiance of a few lamps tells them: √(z/(π f·cosθo)) = l²/(a √R) is linear in

    c1 = a/√R    c2 = b/√R    c3 = (1 + b²)/(a √R):        c1 (1 − z²) + 2 c2 x z + c3 z²

and R = 1/(c1 c3 − c2²). The residuals are float32's rounding. Each pixel of one picture sees a face of its
own, tilted to its cosine and of its roughness; the grid is twice as fine as the table. Nodes that cannot be
seen, at roughness 0 (Cycles keeps to 0.001), at grazing, from straight above (where x is undefined), and
where Cycles leaves the lobe out for an albedo below 1e-5, follow from the middle of a cell and the node
behind it; where that is as dark, the table has R = 0.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

NODES = 32  # along each axis of the table
SIDE = 2 * NODES - 1  # of the measured grid: the nodes and the middles between
TABLES = Path(__file__).resolve().parent.parent / "pt_engine" / "bsdfs" / "sheen.npz"
SUNS = [
    (0.6, 0.0, 0.8), (0.7, 0.5, 0.5), (0.5, -0.3, 0.8), (0.9, 0.3, 0.3), (0.2, 0.7, 0.68),
    (0.6, 0.6, 0.53), (0.95, 0.1, 0.1), (0.1, 0.1, 0.95), (0.3, 0.9, 0.2),
]  # fmt: skip


def tilted_faces(cosines: np.ndarray, roughness: np.ndarray) -> bpy.types.Mesh:
    """A face for each pair, over the pixel (number of the cosine, of the roughness), turned toward +x."""
    corners: list[tuple[float, float, float]] = []
    for i, cos in enumerate(cosines):
        slope = np.sqrt((1 - cos) * (1 + cos)) / cos
        for j in range(len(roughness)):
            corners += [(i + x, j + y, (0.5 - x) * slope) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh = bpy.data.meshes.new("Faces")
    mesh.from_pydata(corners, [], np.arange(len(corners)).reshape(-1, 4).tolist())
    attribute = mesh.attributes.new("Roughness", "FLOAT", "FACE")
    attribute.data.foreach_set("value", np.tile(roughness.astype(np.float32), len(cosines)))
    return mesh


def white_sheen() -> bpy.types.Material:
    """Its roughness is the faces' attribute."""
    material = bpy.data.materials.new("Sheen")
    tree = material.node_tree
    tree.nodes.clear()
    sheen, attribute = tree.nodes.new("ShaderNodeBsdfSheen"), tree.nodes.new("ShaderNodeAttribute")
    sheen.inputs["Color"].default_value = (1, 1, 1, 1)
    attribute.attribute_name = "Roughness"
    tree.links.new(attribute.outputs["Fac"], sheen.inputs["Roughness"])
    tree.links.new(sheen.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def add(data: bpy.types.ID) -> bpy.types.Object:
    """An object of `data` in the scene."""
    owner = bpy.data.objects.new(data.name, data)
    bpy.context.scene.collection.objects.link(owner)
    return owner


def build(cosines: np.ndarray, roughness: np.ndarray) -> bpy.types.Object:
    """The scene, seen from straight above; returns its lamp."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    faces = tilted_faces(cosines, roughness)
    faces.materials.append(white_sheen())
    add(faces)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", SIDE, 1e5
    scene.camera = add(camera)
    scene.camera.location = (SIDE / 2, SIDE / 2, 1000)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle, sun.use_shadow = 1.0, 0.0, False
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = SIDE
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 0.01
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 1, False, False
    cycles.max_bounces, cycles.light_sampling_threshold = 0, 0.0
    return add(sun)


def radiance() -> np.ndarray:
    """[cosine, roughness] as Cycles renders it."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "sheen.exr"))
        bpy.context.scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(SIDE * SIDE * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(SIDE, SIDE, -1)[..., 0].T.astype(np.float64)


def fit(wo: np.ndarray, value: np.ndarray) -> tuple[float, float, float]:
    """a, b and R from values f·cosθo toward directions (3, K); NaN where there is no lobe."""
    if not (value > 0).all():
        return np.nan, np.nan, np.nan
    x, _, z = wo
    root = np.sqrt(z / (np.pi * value))
    terms = np.stack([1 - z * z, 2 * x * z, z * z], axis=1)
    c1, c2, c3 = np.linalg.lstsq(terms / root[:, None], np.ones(len(root)), rcond=None)[0]
    albedo = 1 / (c1 * c3 - c2 * c2)
    return c1 * np.sqrt(albedo), c2 * np.sqrt(albedo), albedo


def filled(node: np.ndarray, middle: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Tables (3, K) of nodes; where they are unknown, what the middle of the cell and the node behind say."""
    a, b, albedo = np.where(np.isnan(node), 2 * middle - behind, node)
    return np.stack([np.maximum(a, 0), b, np.maximum(albedo, 0)])  # what rounding has left is no less than 0


def nodes_of(grid: np.ndarray) -> np.ndarray:
    """Tables (3, NODES, NODES) from the fine grid's (3, SIDE, SIDE), [roughness, cosine]."""
    grid = grid.copy()
    grid[:, 0] = grid[:, :, 0] = grid[:, :, -1] = np.nan
    for j in range(0, SIDE - 2, 2):
        grid[:, j] = filled(grid[:, j], grid[:, j + 1], grid[:, j + 2])
    for i, step in ((0, 1), (-1, -1)):
        grid[:, :, i] = filled(grid[:, :, i], grid[:, :, i + step], grid[:, :, i + 2 * step])
    nodes = grid[:, ::2, ::2]
    return np.where(np.isnan(nodes), np.array([1.0, 0.0, 0.0])[:, None, None], nodes)


def main() -> None:
    """Measure and save."""
    cosines = roughness = np.arange(SIDE) / (SIDE - 1)
    cosines = np.maximum(cosines, 0.5 * cosines[1])  # a face seen along its plane shows nothing
    lamp = build(cosines, roughness)
    sines = np.sqrt(1 - cosines**2)
    directions, values = [], []
    for sun in np.array(SUNS) / np.linalg.norm(SUNS, axis=1, keepdims=True):
        lamp.rotation_euler = Vector(sun).to_track_quat("Z", "Y").to_euler()
        values.append(radiance())
        x, z = sun[2] * sines - sun[0] * cosines, sun[0] * sines + sun[2] * cosines
        directions.append(np.stack([x, np.full(SIDE, sun[1]), z]))
    wo, value = np.moveaxis(directions, 0, -1), np.moveaxis(values, 0, -1)  # [3, cosine, sun], [.., .., sun]
    grid = np.array([[fit(wo[:, i], value[i, j]) for i in range(SIDE)] for j in range(SIDE)])
    a, b, albedo = nodes_of(np.moveaxis(grid, -1, 0)).astype(np.float32)
    np.savez_compressed(TABLES, a=a, b=b, albedo=albedo)


if __name__ == "__main__":
    main()
