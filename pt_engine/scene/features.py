"""Which effects a scene calls for. What it does not have costs nothing, and the report says what was off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .snapshot import Snapshot

if TYPE_CHECKING:
    from .scene import Scene

ON = "on"


def features(snapshot: Snapshot, scene: Scene, film_transparent: bool) -> dict[str, str]:
    """Effect → "on", or "off: why"."""
    camera, lights, geometry = snapshot.camera, scene.lights.description, scene.geometry
    batches = scene.used_batches
    needs = {need.split(":")[0] for b in batches for need in b.needs}
    rows = {
        "motion blur": (snapshot.motion is not None, "nothing moves while the shutter is open"),
        "depth of field": (camera.aperture_radius > 0, "the camera has no aperture"),
        "environment": (scene.world.emits, "the world is black"),
        "environment sampling": (
            scene.world.emits and scene.world.constant is None,
            "the world is the same in all directions",
        ),
        "lamps": (scene.lights.lamps > 0, "no lamp has power"),
        "Dirac lamps": (lights.has_delta, "every lamp has a size"),
        "lamps met by rays": (lights.meets_lamps, "no lamp has a size to hit"),
        "mesh lights": (lights.has_triangles, "no visible material emits"),
        "mesh lights that vary": (
            bool(scene.materials.emission_varies[scene.used_materials].any()),
            "emission is constant on each material",
        ),
        "light choice": (scene.lights.power.size > 1, "there are fewer than two emitters"),
        "light choice by place": (
            scene.lights.by_place is not None,
            "few emitters are in the scene's own space",
        ),
        "curves and points": (geometry.rounds is not None, "all that is seen is made of triangles"),
        "shading normals": (bool(geometry.surface_smooth.any()), "every face is flat"),
        "fading before the shadow terminator": (
            scene.light_angles is not None,
            "no object asks for it",
        ),
        "curved shadow terminators": (
            scene.terminator is not None and scene.terminator.lifts,
            "no smooth mesh has a geometry offset",
        ),
        "transparent surfaces": (scene.transparent_surfaces, "no visible material is transparent"),
        "transparent film": (film_transparent, "the sky is part of the image"),
        "holdouts": (scene.holds_out, "no visible material or object is one"),
        "shadow catchers": (scene.has_catchers, "no object is one"),
        "light linking": (scene.reach.linking is not None, "every light reaches all objects"),
        "shadow linking": (scene.reach.apart is not None, "every object shades all lights"),
        "ray visibility": (scene.seen_apart, "every object is seen by all rays"),
        "ray portals": (scene.has_portals, "no visible material is one"),
        "ideal specular": (any(b.delta_only for b in batches), "no material is made of Dirac lobes alone"),
        "several closures": (
            any(len(b.kinds) > 1 for b in batches),
            "every material has a single closure",
        ),
        "rays from shading": ("traced" in needs, "no visible material looks around"),
        "displacement": (
            any(int(m) in scene.materials.displacement for m in scene.used_materials),
            "no visible material moves vertices",
        ),
        "uv maps": ("uv" in needs or "tangent" in needs, "no visible material reads one"),
        "colour attributes": ("color" in needs, "no visible material reads one"),
        "material batches": (len(scene.groups) > 1, "all materials share one program"),
    }
    return {name: ON if on else f"off: {why}" for name, (on, why) in rows.items()}
