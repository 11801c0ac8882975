"""Whether a snapshot is what its types say: for snapshots that come from outside.

Types come from the annotations of the dataclasses, as they are written there. Shapes, index ranges and
links are checked here by hand, since an index past its array would be a wild read inside Embree.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from . import snapshot as data

ARRAYS: dict[str, tuple[str, ...]] = {
    "Float32": ("float32",),
    "Float64": ("float64",),
    "Int32": ("int32",),
    "NDArray[np.uint8]": ("uint8",),
    "PixelArray": ("float32", "uint8"),
}
SCALARS: dict[str, tuple[type, ...]] = {"str": (str,), "bool": (bool,), "int": (int,), "float": (float, int)}
CLASSES: dict[str, type] = {
    cls.__name__: cls
    for cls in (
        data.Snapshot,
        data.MeshData,
        data.CurvesData,
        data.PointsData,
        data.Instances,
        data.Graph,
        data.Node,
        data.ImageData,
        data.LightData,
        data.CameraData,
        data.Linking,
        data.Stereo,
        data.Motion,
        data.InstanceMotion,
        data.MeshMotion,
        data.RoundMotion,
    )
}


class SnapshotError(ValueError):
    """A snapshot file that can't be read, and why."""


def check(snapshot: object) -> data.Snapshot:
    """`snapshot` itself, where it is a well-formed `Snapshot`; else raise `SnapshotError`."""
    if not isinstance(snapshot, data.Snapshot):
        raise SnapshotError("malformed: the whole is no Snapshot")
    check_types(snapshot, "snapshot")
    for mesh in snapshot.meshes:
        check_mesh(mesh)
    for curves in snapshot.curves:
        check_curves(curves)
    for points in snapshot.points:
        check_points(points)
    check_instances(snapshot)
    if snapshot.linking is not None:
        check_linking(snapshot.linking, snapshot)
    graphs = [*snapshot.materials, snapshot.world, *(light.graph for light in snapshot.lights)]
    for graph in graphs:
        if graph is not None:
            check_graph(graph, len(snapshot.images))
    for image in snapshot.images:
        check_image(image, snapshot.images)
    for light in snapshot.lights:
        shape(light.matrix, (4, 4), "a lamp's matrix")
        require(0 <= light.visibility <= 255, "a lamp's visibility is no set of rays")
        require(light.max_bounces >= 0, "a lamp's bounces are negative")
        require(0 <= light.group < 1 << 31, "a lamp's group is out of range")
    shape(snapshot.camera.matrix, (4, 4), "the camera's matrix")
    require(len(snapshot.materials) > 0, "there is no material 0")
    require(0 <= snapshot.world_visibility <= 255, "the world's visibility is no set of rays")
    if snapshot.motion is not None:
        check_motion(snapshot.motion, snapshot)
    return snapshot


def require(condition: object, problem: str) -> None:
    """Raise with `problem` unless the condition holds."""
    if not condition:
        raise SnapshotError(f"malformed: {problem}")


def shape(array: Any, expected: tuple[int | None, ...], what: str) -> None:
    """Check an array's shape; None stands for any length."""
    fits = array.ndim == len(expected) and all(
        wanted is None or size == wanted for size, wanted in zip(array.shape, expected, strict=True)
    )
    require(fits, f"{what} has shape {array.shape}")


def within(array: Any, count: int, what: str) -> None:
    """Check that indices are in [0, count)."""
    require(array.size == 0 or (array.min() >= 0 and array.max() < count), f"{what} points past its array")


def check_types(value: Any, where: str) -> None:
    """Check every field of a dataclass against its annotation."""
    for field in dataclasses.fields(value):
        check_value(getattr(value, field.name), str(field.type), f"{where}.{field.name}")


def check_value(value: Any, kind: str, where: str) -> None:
    """Check one value against an annotation of `snapshot`, as deep as it goes."""
    if kind.endswith(" | None"):
        if value is None:
            return
        kind = kind.removesuffix(" | None")
    if kind in ARRAYS:
        fits = isinstance(value, np.ndarray) and value.dtype.name in ARRAYS[kind]
        require(fits, f"{where} is no array of {' or '.join(ARRAYS[kind])}")
    elif kind in SCALARS:
        require(type(value) in SCALARS[kind], f"{where} is a {type(value).__name__}")
    elif kind in CLASSES:
        require(type(value) is CLASSES[kind], f"{where} is a {type(value).__name__}")
        check_types(value, where)
    elif kind == "Link":
        require(type(value) is data.Link and type(value.node) is int, f"{where} is no link")
        require(type(value.socket) is str, f"{where} is no link")
    elif kind == "Value | Link":
        check_input(value, where)
    elif kind == "object":
        check_plain(value, where)
    elif kind.startswith("tuple["):
        check_tuple(value, parts_of(kind), where)
    else:
        check_dict(value, parts_of(kind), where)


def parts_of(kind: str) -> list[str]:
    """What stands between the brackets of ``tuple[...]`` or ``dict[...]``, split at the outer commas."""
    parts, depth = [""], 0
    for letter in kind[kind.index("[") + 1 : -1]:
        depth += {"[": 1, "]": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def check_tuple(value: Any, kinds: list[str], where: str) -> None:
    """Check a tuple of a fixed or any length."""
    require(type(value) is tuple, f"{where} is no tuple")
    if kinds[-1] == "...":
        kinds = kinds[:1] * len(value)
    require(len(value) == len(kinds), f"{where} has {len(value)} items")
    for number, (item, kind) in enumerate(zip(value, kinds, strict=True)):
        check_value(item, kind, f"{where}[{number}]")


def check_dict(value: Any, kinds: list[str], where: str) -> None:
    """Check a dict's values (its keys are strings already)."""
    require(type(value) is dict, f"{where} is no dict")
    for key, item in value.items():
        check_value(item, kinds[1], f"{where}[{key!r}]")


def check_input(value: Any, where: str) -> None:
    """Check a socket's link or value: a number, a word, or some numbers."""
    if type(value) is data.Link:
        check_value(value, "Link", where)
    elif type(value) is tuple:
        require(all(type(item) in (bool, int, float) for item in value), f"{where} are no numbers")
    else:
        check_plain(value, where)


def check_plain(value: Any, where: str) -> None:
    """Check a node's setting: numbers, strings and nested tuples."""
    if type(value) is tuple:
        for item in value:
            check_plain(item, where)
    else:
        require(
            value is None or type(value) in (str, bool, int, float), f"{where} is a {type(value).__name__}"
        )


def check_mesh(mesh: data.MeshData) -> None:
    """Shapes and index ranges of a mesh."""
    count = len(mesh.triangles)
    shape(mesh.vertices, (None, 3), "vertices")
    shape(mesh.triangles, (None, 3), "triangles")
    within(mesh.triangles, len(mesh.vertices), "triangles")
    shape(mesh.material_slot, (count,), "material_slot")
    require(count == 0 or int(np.min(mesh.material_slot)) >= 0, "material_slot is negative")
    shape(mesh.texture_space, (2, 3), "texture_space")
    require((mesh.normals is None) == (mesh.normal_index is None), "normals without normal_index")
    if mesh.normals is not None and mesh.normal_index is not None:
        shape(mesh.normals, (None, 3), "normals")
        shape(mesh.normal_index, (count, 3), "normal_index")
        within(mesh.normal_index, len(mesh.normals), "normal_index")
    if mesh.flat is not None:
        shape(mesh.flat, (count,), "flat")
    if mesh.orco is not None:
        shape(mesh.orco, (len(mesh.vertices), 3), "orco")
    check_layers(mesh)


def check_layers(mesh: data.MeshData) -> None:
    """UV maps and colours: every layer long enough for the index that reads it."""
    corners = mesh.corner_index
    if corners is not None:
        shape(corners, (len(mesh.triangles), 3), "corner_index")
        within(corners, 1 << 31, "corner_index")
    longest = -1 if corners is None or not corners.size else int(np.max(corners))
    for name, layer in mesh.uvs.items():
        shape(layer, (None, 2), f"uv map {name}")
        require(corners is not None and longest < len(layer), f"uv map {name} is too short")
    for name, layer in mesh.colors.items():
        shape(layer, (None, 4), f"color {name}")
        by_corner = corners is not None and longest < len(layer)
        require(by_corner or len(layer) == len(mesh.vertices), f"color {name} is too short")


def check_curves(curves: data.CurvesData) -> None:
    """Shapes of strands, and that they follow each other."""
    points, count = len(curves.points), len(curves.material_slot)
    shape(curves.points, (None, 3), "curves.points")
    shape(curves.radius, (points,), "curves.radius")
    shape(curves.first, (count + 1,), "curves.first")
    first = curves.first.astype(np.int64)
    follow = first[0] == 0 and first[-1] == points and bool((np.diff(first) >= 0).all())
    require(follow, "curves.first does not cover the points")
    require(count == 0 or int(np.min(curves.material_slot)) >= 0, "material_slot is negative")
    require(curves.shape in ("RIBBON", "THICK", "LINEAR"), f"curves are {curves.shape}")
    require(0 <= curves.subdivisions <= 64, "curves.subdivisions is out of range")
    for name, layer in curves.uvs.items():
        shape(layer, (count, 2), f"uv map {name}")
    for name, layer in curves.colors.items():
        shape(layer, (points if len(layer) == points else count, 4), f"color {name}")
    if curves.generated is not None:
        shape(curves.generated, (count, 3), "curves.generated")
    if curves.normals is not None:
        shape(curves.normals, (points, 3), "curves.normals")


def check_points(points: data.PointsData) -> None:
    """Shapes of a point cloud."""
    count = len(points.points)
    shape(points.points, (None, 3), "points.points")
    shape(points.radius, (count,), "points.radius")
    for name, layer in points.uvs.items():
        shape(layer, (count, 2), f"uv map {name}")
    for name, layer in points.colors.items():
        shape(layer, (count, 4), f"color {name}")


def check_instances(snapshot: data.Snapshot) -> None:
    """Rows of equal number that point at what there is."""
    rows = snapshot.instances
    count = len(rows.mesh)
    shape(rows.mesh, (count,), "instances.mesh")
    placed = len(snapshot.meshes) + len(snapshot.curves) + len(snapshot.points)
    within(rows.mesh, placed, "instances.mesh")
    shape(rows.matrix, (count, 4, 4), "instances.matrix")
    shape(rows.materials, (count, None), "instances.materials")
    require(count == 0 or rows.materials.shape[1] > 0, "instances have no material")
    within(rows.materials, len(snapshot.materials), "instances.materials")
    shape(rows.color, (count, 4), "instances.color")
    for name in ("random", "pass_index", "visibility"):
        shape(getattr(rows, name), (count,), f"instances.{name}")
    require(len(rows.names) == count, "instances.names has another length")
    for name, values in rows.attributes.items():
        shape(values, (count, 4), f"instances.attributes {name}")
    for name in ("terminator", "shading_offset"):
        if getattr(rows, name) is not None:
            shape(getattr(rows, name), (count,), f"instances.{name}")
    groups = len(snapshot.light_groups) + 1
    if rows.light_group is not None:
        shape(rows.light_group, (count,), "instances.light_group")
        within(rows.light_group, groups, "instances.light_group")
    others = [snapshot.world_light_group, *(light.light_group for light in snapshot.lights)]
    require(all(0 <= number < groups for number in others), "there is no such light group")


def check_linking(links: data.Linking, snapshot: data.Snapshot) -> None:
    """Sets that exist, for every instance and lamp."""
    count = (len(snapshot.instances.mesh),)
    shape(links.receives, (None, None), "linking.receives")
    shape(links.blocks, (None, links.receives.shape[1]), "linking.blocks")
    for name, table in (("receiver", links.receives), ("blocker", links.blocks), ("emitter", links.blocks.T)):
        shape(getattr(links, name), count, f"linking.{name}")
        within(getattr(links, name), len(table), f"linking.{name}")
    for light in snapshot.lights:
        require(0 <= light.group < links.receives.shape[1], "a lamp's group is missing")


def check_motion(motion: data.Motion, snapshot: data.Snapshot) -> None:
    """Steps of what there is, at two times or more."""
    shape(motion.shutter, (None,), "the shutter's curve")
    require(len(motion.shutter) > 1 and len(motion.cameras) != 1, "a motion has a single step")
    require(0 <= motion.row_exposure <= 1, "rows are exposed for no share of the time")
    for rows in motion.instances:
        shape(rows.instance, (None,), "moving instances")
        within(rows.instance, len(snapshot.instances.mesh), "a moving instance")
        shape(rows.matrix, (len(rows.instance), None, 4, 4), "matrices of moving instances")
        require(rows.matrix.shape[1] > 1, "a motion has a single step")
    counts = [len(curves.points) for curves in snapshot.curves]
    counts += [len(points.points) for points in snapshot.points]
    for bent in motion.rounds:
        number = bent.geometry - len(snapshot.meshes)
        require(0 <= number < len(counts), "deforming curves or points are missing")
        size = len(bent.points), counts[number]
        require(size[0] > 1, "a motion has a single step")
        shape(bent.points, (*size, 3), "deforming curves or points")
        shape(bent.radius, size, "radii of deforming curves or points")
    for moved in motion.meshes:
        require(0 <= moved.mesh < len(snapshot.meshes), "a deforming mesh is missing")
        still, steps = snapshot.meshes[moved.mesh], len(moved.vertices)
        require(steps > 1, "a motion has a single step")
        shape(moved.vertices, (steps, len(still.vertices), 3), "vertices of a deforming mesh")
        require((moved.normals is None) == (still.normals is None), "a deforming mesh lacks its normals")
        if moved.normals is not None and still.normals is not None:
            shape(moved.normals, (steps, len(still.normals), 3), "normals of a deforming mesh")
    for camera in motion.cameras:
        shape(camera.matrix, (4, 4), "the camera's matrix")


def check_graph(graph: data.Graph, images: int) -> None:
    """Links that lead back to earlier nodes, images that exist."""
    for number, node in enumerate(graph.nodes):
        for link in node.inputs.values():
            if isinstance(link, data.Link):
                require(0 <= link.node < number, f"{graph.name}: a link does not lead to an earlier node")
        image = node.props.get("image")
        known = image is None or (type(image) is int and 0 <= image < images)
        require(known, f"{graph.name}: image {image!r} is missing")
    for link in graph.outputs.values():
        require(0 <= link.node < len(graph.nodes), f"{graph.name}: an output has no node")


def check_image(image: data.ImageData, images: tuple[data.ImageData, ...]) -> None:
    """Pixels, a file or tiles, not several of them; tiles that exist and have none of their own."""
    kinds = [image.pixels is not None, image.encoded is not None, len(image.tiles) > 0]
    require(sum(kinds) <= 1, f"image {image.name} is several things at once")
    if image.pixels is not None:
        shape(image.pixels, (None, None, 4), f"image {image.name}")
    if image.encoded is not None:
        shape(image.encoded, (None,), f"image {image.name}")
    for number, index in image.tiles:
        known = 0 <= index < len(images) and not images[index].tiles
        require(known and 1001 <= number <= 2000, f"image {image.name}: tile {number} is missing")
