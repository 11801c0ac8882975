"""Attributes that geometry nodes store on instances, found for instances of instances, too.

A persistent id has a number for each level, the innermost first. On a level of geometry nodes it is the
instance's "id", or its place among the instances, or that of a part (mesh, curves ...) beside them; on one of
a collection the object's place there. An inner level's attribute hides those of outer ones.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from .properties import Rgba, as_rgba

WITH_GEOMETRY = {"MESH", "CURVE", "SURFACE", "FONT", "CURVES", "POINTCLOUD", "VOLUME", "GREASEPENCIL"}
UNUSED = 2**31 - 1  # in the parts of a persistent id that a less nested instance does not need
PARTS = {  # of a geometry that count before its instances, and the types of objects that are such a part
    "mesh": {"MESH"},
    "volume": {"VOLUME"},
    "curves": {"CURVE", "FONT", "CURVES"},
    "pointcloud": {"POINTCLOUD"},
    "grease_pencil": {"GREASEPENCIL"},
}


class InstanceLayers:
    """Values by name, read once for each geometry; to be asked within the loop step of an instance."""

    def __init__(self) -> None:
        self._levels: dict[object, Level | None] = {}

    def rgba(self, instance, name: str) -> Rgba | None:
        """The attribute of an instance, None where it has none of that name."""
        numbers = [part for part in instance.persistent_id if part != UNUSED][::-1]
        found = None
        for level, number in self.way(instance.parent, numbers):
            values = level.values(name)
            if number < len(values):
                found = values[number]
        return found

    def way(self, here, numbers: list[int]) -> Iterator[tuple[Level, int]]:
        """The levels from the instancer inward, and which instance of each it is."""
        left, key = iter(numbers), (here.as_pointer(),)
        for number in left:
            objects = objects_of(here)
            if objects is not None:
                key = (*key, number)
                if number >= len(objects):
                    return
                here = objects[number]
                continue
            if key not in self._levels:
                self._levels[key] = level_of(here)
            level = self._levels[key]
            if level is None:
                return
            if level.parts:
                number = next(left, UNUSED)
            place = level.place(number)
            if place is None:
                return
            yield level, place
            here, key = level.inner(place), (*key, level.handles[place])
            if here is None:
                return


class Level:
    """The instances of one geometry.

    Attributes
    ----------
    parts : bool
        Whether other parts of the geometry are numbered before the instances.
    handles : list of int
        Which of the geometry's references each instance shows.
    """

    def __init__(self, geometry, cloud, parts: bool) -> None:
        self._geometry, self._cloud, self.parts = geometry, cloud, parts  # the geometry owns the cloud
        self._references = geometry.instance_references()
        self._values: dict[str, list[Rgba | None]] = {}
        self.handles = [item.value for item in cloud.attributes[".reference_index"].data]
        ids = cloud.attributes.get("id")
        numbers = range(len(self.handles)) if ids is None else (item.value for item in ids.data)
        self._places: dict[int, int] = {}
        # those whose id another has: Blender numbers them anew, and shows them in order
        self._doubles: list[int] = []
        for place, number in enumerate(numbers):
            if self._places.setdefault(number, place) != place:
                self._doubles.append(place)

    def place(self, number: int) -> int | None:
        """Which instance has a number in persistent ids."""
        if number not in self._places and self._doubles:
            self._places[number] = self._doubles.pop(0)
        return self._places.get(number)

    def values(self, name: str) -> list[Rgba | None]:
        """Of an attribute; [] where there is none."""
        if name not in self._values:
            layer = self._cloud.attributes.get(name)
            fields = () if layer is None or not len(layer.data) else ("value", "vector", "color")
            field = next((field for field in fields if hasattr(layer.data[0], field)), None)
            self._values[name] = [] if field is None else [as_rgba(getattr(x, field)) for x in layer.data]
        return self._values[name]

    def inner(self, place: int):
        """The object, collection or geometry that an instance shows."""
        return self._references[self.handles[place]]


def level_of(here) -> Level | None:
    """The instances of an object, or of a geometry that is an instance itself."""
    kind, geometry = "", here
    if isinstance(here, bpy.types.Object):
        if here.type not in WITH_GEOMETRY or not hasattr(here, "evaluated_geometry"):
            return None
        kind, geometry = here.type, here.evaluated_geometry()
    cloud = geometry.instances_pointcloud()
    if cloud is None or ".reference_index" not in cloud.attributes:
        return None
    parts = any(getattr(geometry, name, None) is not None for name, own in PARTS.items() if kind not in own)
    return Level(geometry, cloud, parts)


def objects_of(here) -> list | None:
    """The objects that a collection places, by number: geometry nodes' have two numbers each."""
    if isinstance(here, bpy.types.Collection):
        return [one for one in here.all_objects if not one.hide_render for _ in range(2)]
    if isinstance(here, bpy.types.Object) and here.instance_type == "COLLECTION":
        return list(here.instance_collection.all_objects) if here.instance_collection else []
    return None
