"""Every placed mesh, strand, point and lamp of the depsgraph, geometry shared by those that look alike.

An instance of `depsgraph.object_instances` lives only in its loop step, so what can be read for all at once
(matrices, random ids) is read with `foreach_get`, and what belongs to the object is read once per object.

Curves, text, surfaces and metaballs come twice: as themselves and as an instance of their mesh. Only the
mesh counts.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...scene.snapshot import Instances, Visibility
from .curves import curve_shape, export_curves, export_strands, hair_systems
from .light_groups import LightGroups
from .lights import export_light
from .linking import Links
from .meshes import export_mesh
from .needs import Needs, graph_needs, union
from .placed import PlacedAttributes
from .points import export_points
from .random_id import random_of

NOT_RENDERED = {
    "VOLUME": "volume object",
    "GREASEPENCIL": "grease pencil",
    "GPENCIL": "grease pencil",
}


GEOMETRY = {"MESH", "CURVES", "POINTCLOUD"}
CURVES_FROM, POINTS_FROM = 1 << 28, 1 << 29  # numbers of curves and points while meshes are being counted


class Look(NamedTuple):
    """What all instances of one object with one geometry share."""

    mesh: int
    materials: tuple[int, ...]
    visibility: int
    color: tuple[float, ...]
    pass_index: int
    name: str
    sets: tuple[int, int, int]
    terminator: float
    shading_offset: float
    light_group: int


@dataclass
class Collector:
    """Walks the instances twice: to learn which materials each mesh has, then to read the meshes."""

    depsgraph: object
    materials: object
    images: object
    unsupported: list
    dicing: object
    meshes: list = field(default_factory=list)
    curves: list = field(default_factory=list)
    points: list = field(default_factory=list)
    lights: list = field(default_factory=list)
    linking: object = None
    needs: dict = field(default_factory=dict)

    def __post_init__(self):
        self.view_layer = self.depsgraph.view_layer_eval
        self.links, self.groups = Links(self.depsgraph), LightGroups(self.view_layer)
        self._slots: dict = {}
        self._mesh_number: dict = {}
        self.viewport = self.depsgraph.mode == "VIEWPORT"
        self.curve_shape = curve_shape(self.depsgraph.scene_eval)
        self._graph_needs: dict = {}

    def run(self) -> Instances:
        """All instances; fills `meshes`, `lights`, `linking`, and `rows`: where the depsgraph has each."""
        self.learn_materials()
        rows: list[int] = []
        looks: list[Look] = []
        known: dict = {}
        wanted = union(self._graph_needs.values()).objects
        placed = PlacedAttributes(wanted, self.depsgraph.scene_eval.frame_current_final)
        for row, instance in enumerate(self.depsgraph.object_instances):
            owner = instance.object
            kind = owner.type
            if kind == "LIGHT":
                self.light(instance)
            elif kind in GEOMETRY:
                key = self.key(instance, owner)
                for hair in self.shown(instance, owner):
                    look = known.get((key, hair))
                    if look is None:
                        look = known[key, hair] = self.look(instance, owner, hair)
                    if look.mesh >= 0:
                        rows.append(row)
                        looks.append(look)
                        placed.add(instance)
            elif kind in NOT_RENDERED:
                self.unsupported.append((f"Object {owner.name}", NOT_RENDERED[kind], "missing in the image"))
        self.linking = self.links.table([look.sets for look in looks])
        self.rows = np.array(rows, np.intp)
        return self.table(self.rows, looks, placed.table())

    @staticmethod
    def key(instance, owner):
        """Equal for instances that share all that `Look` holds."""
        parent = instance.parent
        return owner.original.as_pointer(), owner.data.as_pointer(), parent and parent.as_pointer()

    def shown(self, instance, owner) -> list[bool]:
        """What is to be seen of an instance: False for its own geometry, True for its particles' strands."""
        own = instance.show_self and (owner.type != "CURVES" or self.view_layer.use_strand)
        if owner.type == "MESH":
            own = own and self.view_layer.use_solid
            if instance.show_particles and self.view_layer.use_strand:
                return [False] * own + [True] * bool(hair_systems(owner, self.viewport))
        return [False] * own

    def learn_materials(self) -> None:
        """Which layers each mesh must bring, from the materials of all who use it."""
        for instance in self.depsgraph.object_instances:
            owner = instance.object
            if owner.type not in GEOMETRY or not self.shown(instance, owner):
                continue
            key = owner.original.as_pointer(), owner.data.as_pointer()
            if key not in self._slots:
                self._slots[key] = slots = self.slot_materials(owner)
                needs = union(self.material_needs(number) for number in slots)
                self.needs[key[1]] = self.needs.get(key[1], Needs()) | needs

    def slot_materials(self, owner) -> tuple[int, ...]:
        """Material numbers of an object's slots, its own links and the view layer's override observed."""
        override = self.view_layer.material_override
        if override is not None:
            return (self.materials.index(override),)
        return tuple(self.materials.index(material) for material in slots_of(owner)) or (0,)

    def material_needs(self, number: int) -> Needs:
        if number not in self._graph_needs:
            self._graph_needs[number] = graph_needs(self.materials.graphs[number])
        return self._graph_needs[number]

    def look(self, instance, owner, hair: bool) -> Look:
        data = owner.data.as_pointer()
        known = (owner.original.as_pointer(), data) if hair else data
        if known not in self._mesh_number:
            self._mesh_number[known] = self.geometry(instance, owner, data, hair)
        return Look(
            self._mesh_number[known],
            self._slots[owner.original.as_pointer(), data],
            self.visibility(instance, owner),
            tuple((instance.parent if instance.is_instance else owner).color),  # an instancer's, as in Cycles
            owner.pass_index,
            owner.name,
            self.links.sets(owner, instance.parent),
            owner.shadow_terminator_geometry_offset,
            0.0 if hair or owner.type == "CURVES" else owner.shadow_terminator_shading_offset,
            self.groups.number(instance),
        )

    def geometry(self, instance, owner, data: int, hair: bool) -> int:
        """Number of a new geometry, -1 where there is nothing of it."""
        if owner.type == "POINTCLOUD":
            return listed(self.points, POINTS_FROM, export_points(owner.name, owner.data, self.needs[data]))
        if owner.type == "CURVES":
            curves = export_curves(owner.name, owner.data, self.needs[data], *self.curve_shape)
            return listed(self.curves, CURVES_FROM, curves)
        if hair:
            emitter = owner.original.evaluated_get(self.depsgraph)
            strands = export_strands(emitter, self.viewport, self.needs[data], *self.curve_shape)
            return listed(self.curves, CURVES_FROM, strands)
        return self.mesh(owner, data, instance.matrix_world)

    def mesh(self, owner, data: int, matrix) -> int:
        """Number of a new mesh, -1 where it has no triangles."""
        mesh = owner.to_mesh()
        try:
            exported = export_mesh(owner.data.name, mesh, self.needs[data])
        finally:
            owner.to_mesh_clear()
        if exported is None:
            return -1
        self.meshes.append(self.dicing.dice(owner, exported, matrix))
        return len(self.meshes) - 1

    def light(self, instance) -> None:
        visibility = self.visibility(instance, instance.object)
        group = self.links.sets(instance.object, instance.parent)[2]
        light = export_light(instance, visibility, group, self.images, self.unsupported)
        if light is not None:
            self.lights.append(replace(light, light_group=self.groups.number(instance)))

    def visibility(self, instance, owner) -> int:
        """Bits of `Visibility`; an instance is seen only where its instancer is seen as well."""
        parent = instance.parent if instance.is_instance else owner
        bits = ray_visibility(owner)
        if parent is not None and parent != owner:
            bits &= ray_visibility(parent)
        real = (parent or owner).original
        if real.holdout_get(view_layer=self.depsgraph.view_layer) or owner.is_holdout:
            bits |= Visibility.HOLDOUT
        elif real.indirect_only_get(view_layer=self.depsgraph.view_layer):
            bits &= ~Visibility.CAMERA
        if owner.is_shadow_catcher and owner.type != "LIGHT":
            bits |= Visibility.CATCHER
        return bits

    def final_number(self, number: int) -> int:
        """Of a geometry, when all are known: meshes, then curves, then points."""
        if number >= POINTS_FROM:
            return number - POINTS_FROM + len(self.meshes) + len(self.curves)
        return number - CURVES_FROM + len(self.meshes) if number >= CURVES_FROM else number

    def table(self, rows, looks, attributes) -> Instances:
        """Struct of arrays."""
        every = self.depsgraph.object_instances
        total = len(every)
        matrix = np.empty(total * 16, np.float32)
        every.foreach_get("matrix_world", matrix)
        random_id = np.empty(total, np.int32)
        every.foreach_get("random_id", random_id)
        is_instance = np.empty(total, np.bool_)
        every.foreach_get("is_instance", is_instance)
        names = tuple(look.name for look in looks)
        width = max((len(look.materials) for look in looks), default=1)
        count = len(looks)
        padded = [look.materials + look.materials[-1:] * (width - len(look.materials)) for look in looks]
        return Instances(
            mesh=np.array([self.final_number(look.mesh) for look in looks], np.int32),
            matrix=matrix.reshape(total, 4, 4).transpose(0, 2, 1)[rows].astype(np.float64),
            materials=np.array(padded, np.int32).reshape(count, width),
            random=random_of(random_id[rows], names, is_instance[rows]),
            color=np.array([look.color for look in looks], np.float32).reshape(count, 4),
            pass_index=np.array([look.pass_index for look in looks], np.int32),
            visibility=np.array([look.visibility for look in looks], np.uint8),
            names=names,
            attributes=attributes,
            terminator=np.array([look.terminator for look in looks], np.float32),
            shading_offset=np.array([look.shading_offset for look in looks], np.float32),
            light_group=np.array([look.light_group for look in looks], np.int32),
        )


def listed(geometries: list, start: int, geometry) -> int:
    """The number of a geometry that is put into a list; -1 for none."""
    if geometry is None:
        return -1
    geometries.append(geometry)
    return start + len(geometries) - 1


def slots_of(owner) -> list:
    """Material of each slot: the object's own where the slot says so, else the evaluated mesh's.

    Geometry that comes from geometry nodes has slots that the object doesn't know of. An empty slot of the
    object hides the mesh's material, though the evaluated object names that.
    """
    own = owner.material_slots
    materials = list(owner.data.materials)
    for number, (slot, original) in enumerate(zip(own, owner.original.material_slots, strict=False)):
        if number >= len(materials):
            materials.append(slot.material)
        elif slot.link == "OBJECT":
            materials[number] = slot.material if original.material else None
    return materials


def ray_visibility(owner) -> int:
    """Blender's ray visibility panel as bits."""
    bits = (
        (owner.visible_camera, Visibility.CAMERA),
        (owner.visible_diffuse, Visibility.DIFFUSE),
        (owner.visible_glossy, Visibility.GLOSSY),
        (owner.visible_transmission, Visibility.TRANSMISSION),
        (owner.visible_shadow, Visibility.SHADOW),
        (owner.visible_volume_scatter, Visibility.VOLUME),
    )
    return sum(bit for seen, bit in bits if seen)
