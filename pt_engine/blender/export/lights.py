"""Lamps, in the units of their panels: power, colour, shape; see `LightData`."""

from __future__ import annotations

import math

import numpy as np

from ...scene.snapshot import UNLIMITED, LightData
from .materials import tree_graph
from .random_id import MASK, random_of


def export_light(instance, visibility: int, group: int, images, unsupported) -> LightData | None:
    """One lamp of a depsgraph instance; None for a portal, which gives no light but guides sampling to it."""
    owner = instance.object
    light = owner.data
    where = f"Light {owner.name}"
    cycles = getattr(light, "cycles", None)
    if getattr(cycles, "is_portal", False) and light.type == "AREA":
        return None
    if light.type == "SPOT" and light.use_square:
        unsupported.append((where, "square spot", "the viewport's only: rendered as a cone"))
    return LightData(
        kind=light.type,
        name=owner.name,
        matrix=np.array(instance.matrix_world, np.float64),
        power=light.energy * 2.0**light.exposure,
        color=light_color(light),
        use_mis=getattr(cycles, "use_multiple_importance_sampling", True),
        cast_shadow=light.use_shadow,
        normalize=light.normalize,
        visibility=visibility,
        max_bounces=min(getattr(cycles, "max_bounces", UNLIMITED), UNLIMITED),
        group=group,
        real=owner.is_shadow_catcher,
        graph=tree_graph(light, light.name, images, "from_light"),
        object_color=tuple((instance.parent if instance.is_instance else owner).color),
        pass_index=owner.pass_index,
        random=random_number(instance, owner),
        **shape(light),
    )


def random_number(instance, owner) -> float:
    """Object Info's, of one object or instance."""
    ids, placed = np.uint32([instance.random_id & MASK]), np.array([instance.is_instance])
    return float(random_of(ids, [owner.name], placed)[0])


def light_color(light) -> tuple[float, float, float]:
    """Colour times that of its temperature."""
    color = tuple(light.color)
    if light.use_temperature:
        color = tuple(a * b for a, b in zip(color, light.temperature_color, strict=False))
    return color


def shape(light) -> dict[str, object]:
    """The fields of `LightData` that depend on the kind."""
    if light.type == "SUN":
        return {"angle": light.angle}
    if light.type == "AREA":
        square = light.shape in ("SQUARE", "DISK")
        size = (light.size, light.size if square else light.size_y)
        return {"shape": light.shape, "size": size, "spread": light.spread}
    fields = {"radius": light.shadow_soft_size, "soft_falloff": light.use_soft_falloff}
    if light.type == "SPOT":
        fields |= {"spot_size": min(light.spot_size, math.pi), "spot_blend": light.spot_blend}
    return fields
