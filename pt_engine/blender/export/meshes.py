"""One evaluated mesh as arrays.

Read with `foreach_get` from the attributes that Blender stores as arrays itself: a million triangles take a
fraction of a second. `vertices['co']` and its like are ten to a hundred times slower.
"""

from __future__ import annotations

import numpy as np

from ...scene.snapshot import MeshData
from .edge_attributes import mean_at_vertices
from .failure import ExportError
from .needs import Needs
from .vertex_attributes import pointiness, random_per_island

READ_AS = {  # attribute data type -> property, dtype, components
    "FLOAT_COLOR": ("color", np.float32, 4),
    "BYTE_COLOR": ("color", np.float32, 4),
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int32, 1),
    "BOOLEAN": ("value", np.bool_, 1),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT2": ("vector", np.float32, 2),
    "QUATERNION": ("value", np.float32, 4),
}
COMPUTED = {"pointiness", "random_per_island"}
PAIRS = "FLOAT2"  # kept with the UV maps, since Cycles takes a number from them in another way


def export_mesh(name: str, mesh, needs: Needs) -> MeshData | None:
    """A mesh with the layers in `needs`; None where it has no triangle.

    Parameters
    ----------
    mesh : bpy.types.Mesh
        Evaluated; its loop triangles are computed here.
    """
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return None
    vertices = read(mesh.attributes["position"].data, "vector", np.float32, 3)
    corner_vertex = read(mesh.attributes[".corner_vert"].data, "value", np.int32)
    corners = read(mesh.loop_triangles, "loops", np.int32, 3)
    refuse_damaged(name, corners, len(corner_vertex))
    triangles = corner_vertex[corners]
    refuse_damaged(name, triangles, len(vertices))
    polygon = read(mesh.loop_triangle_polygons, "value", np.int32)
    good = usable(vertices, triangles)
    if good is not None:
        corners, triangles, polygon = corners[good], triangles[good], polygon[good]
        vertices = np.nan_to_num(vertices, nan=0.0, posinf=0.0, neginf=0.0)
    normals, normal_index = shading_normals(mesh, triangles, corners)
    layers = Layers(mesh, corner_vertex)
    uvs, colors = layers.uvs(needs.uvs), layers.colors(needs.colors)
    return MeshData(
        name=name,
        vertices=vertices,
        triangles=triangles,
        material_slot=material_slots(mesh, polygon),
        normals=normals,
        normal_index=normal_index,
        flat=flat_faces(mesh, polygon) if needs.displaced or needs.uvs else None,
        corner_index=corners if uvs or colors else None,
        uvs=uvs,
        colors=colors,
        active_uv=layers.active_uv,
        active_color=layers.active_color,
        texture_space=np.array([mesh.texspace_location, mesh.texspace_size], np.float32),
        orco=undeformed(mesh, vertices) if needs.generated else None,
    )


def read(collection, name: str, dtype, components: int = 1):
    """A property of all elements as (n,) or (n, components)."""
    flat = np.empty(len(collection) * components, dtype)
    collection.foreach_get(name, flat)
    return flat if components == 1 else flat.reshape(-1, components)


def refuse_damaged(name: str, index, count: int) -> None:
    """Raise where the numbers go past what they count: in Embree's hands they would be wild reads."""
    if len(index) and not 0 <= int(index.min()) <= int(index.max()) < count:
        raise ExportError(
            f"mesh {name}: its faces name corners or vertices that it does not have; mesh.validate() mends it"
        )


def usable(vertices, triangles):
    """Triangles whose corners are all finite, as a mask; None for all of them."""
    finite = np.isfinite(vertices).all(axis=1)
    return None if finite.all() else finite[triangles].all(axis=1)


def material_slots(mesh, polygon):
    """Slot of each triangle."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != "INT":
        return np.zeros(len(polygon), np.int32)
    return np.maximum(read(attribute.data, "value", np.int32)[polygon], 0)


def shading_normals(mesh, triangles, corners):
    """Unit normals and the row of each corner: none for flat faces, else per vertex or per corner."""
    domain = mesh.normals_domain
    if domain == "FACE":
        return None, None
    if domain == "POINT":
        return read(mesh.vertex_normals, "vector", np.float32, 3), triangles
    return read(mesh.corner_normals, "vector", np.float32, 3), corners


def flat_faces(mesh, polygon):
    """Which triangles are of faces without smooth shading, where that differs from face to face."""
    sharp = mesh.attributes.get("sharp_face")
    if mesh.normals_domain != "CORNER" or sharp is None:
        return None
    return read(sharp.data, "value", np.bool_)[polygon].astype(np.uint8)


def undeformed(mesh, vertices):
    """Positions before modifiers and shape keys, where they differ: what Generated is measured by."""
    rest = read(mesh.vertices, "undeformed_co", np.float32, 3)
    if np.array_equal(rest, vertices) or not np.isfinite(rest).all():
        return None
    return rest


def edges_at_vertices(mesh, attribute):
    """(V, ...) an edge attribute as vertices have it."""
    prop, dtype, size = READ_AS[attribute.data_type]
    stored = "color_srgb" if attribute.data_type == "BYTE_COLOR" else prop
    edges = read(mesh.attributes[".edge_verts"].data, "value", np.int32, 2)
    values = read(attribute.data, stored, dtype, size)
    return mean_at_vertices(values, edges, len(mesh.vertices), attribute.data_type)


class Layers:
    """A mesh's UV maps and colour attributes."""

    def __init__(self, mesh, corner_vertex) -> None:
        self.mesh, self.corner_vertex = mesh, corner_vertex
        self.active_uv = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
        index = mesh.color_attributes.render_color_index
        colors = mesh.color_attributes
        self.active_color = colors[index].name if 0 <= index < len(colors) else ""

    def uvs(self, wanted) -> dict:
        """The UV maps and other pairs among `wanted`, (L, 2)."""
        names = {name or self.active_uv for name in wanted}
        return {
            name: self.at_corners(attribute)
            for name, attribute in self.attributes(names).items()
            if attribute.data_type == PAIRS
        }

    def colors(self, wanted) -> dict:
        """The other attributes among `wanted`, as (L, 4)."""
        names = {name or self.active_color for name in wanted}
        stored = {
            name: four_channels(self.at_corners(attribute))
            for name, attribute in self.attributes(names - COMPUTED).items()
            if attribute.data_type != PAIRS
        }
        computed = {name: self.computed(name)[self.corner_vertex] for name in names & COMPUTED}
        return stored | {name: four_channels(values) for name, values in computed.items()}

    def computed(self, name: str):
        """(V,) what Cycles calls by one of its own names."""
        edges = read(self.mesh.attributes[".edge_verts"].data, "value", np.int32, 2)
        if name == "random_per_island":
            return random_per_island(len(self.mesh.vertices), edges)
        positions = read(self.mesh.attributes["position"].data, "vector", np.float32, 3)
        return pointiness(positions, read(self.mesh.vertex_normals, "vector", np.float32, 3), edges)

    def attributes(self, names) -> dict:
        """Those of these names that can be read."""
        found = {name: self.mesh.attributes.get(name) for name in sorted(names)}
        return {name: a for name, a in found.items() if a is not None and a.data_type in READ_AS}

    def at_corners(self, attribute):
        """(L, ...) values, whatever the attribute's domain."""
        if attribute.domain == "EDGE":
            return edges_at_vertices(self.mesh, attribute)[self.corner_vertex]
        values = read(attribute.data, *READ_AS[attribute.data_type])
        if attribute.domain == "POINT":
            return values[self.corner_vertex]
        if attribute.domain == "FACE":
            sizes = read(self.mesh.polygons, "loop_total", np.int32)
            return np.repeat(values, sizes, axis=0)
        return values


def four_channels(values):
    """Numbers x as (x, x, x, 1), vectors as (x, y, z, 1), float32."""
    if values.ndim == 1:
        values = np.repeat(values.astype(np.float32)[:, None], 3, axis=1)
    if values.shape[1] == 4:
        return values
    result = np.zeros((len(values), 4), np.float32)
    result[:, : values.shape[1]] = values
    result[:, 3] = 1.0
    return result
