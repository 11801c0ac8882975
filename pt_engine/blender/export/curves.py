"""Hair as arrays: objects of curves, and the strands of particle systems.

Points of Bézier and NURBS curves count as those of Catmull-Rom splines, as in Cycles.
"""

from __future__ import annotations

import numpy as np

from ...scene.snapshot import CurvesData
from .meshes import PAIRS, READ_AS, four_channels, read
from .needs import Needs

SHAPES = {"RIBBONS": "RIBBON", "THICK": "THICK", "THICK_LINEAR": "LINEAR"}
POLY = 1  # of the attribute curve_type
DEFAULT_RADIUS = 0.005


def curve_shape(scene) -> tuple[str, int]:
    """Shape and subdivisions of all curves: a setting of the scene."""
    settings = getattr(scene, "cycles_curves", None)
    shape = SHAPES.get(getattr(settings, "shape", "RIBBONS"), "RIBBON")
    return shape, min(int(getattr(settings, "subdivisions", 2)), 64)


def export_curves(name: str, curves, needs: Needs, shape: str, subdivisions: int) -> CurvesData | None:
    """The strands of an evaluated Curves; None where it has none."""
    position = curves.attributes.get("position")
    if position is None or not len(position.data):
        return None
    points = read(position.data, "vector", np.float32, 3)
    first = read(curves.curve_offset_data, "value", np.int32)
    stored = {attribute.name: attribute for attribute in curves.attributes}
    kind = stored.get("curve_type")
    if kind is not None and len(kind.data) and kind.data[0].value == POLY:
        shape = "LINEAR"
    active = next((a.name for a in stored.values() if a.data_type == PAIRS and a.domain == "CURVE"), "")
    uvs = {
        wanted: read(stored[wanted].data, *READ_AS[PAIRS])
        for wanted in sorted({name or active for name in needs.uvs} & stored.keys())
        if stored[wanted].data_type == PAIRS and stored[wanted].domain == "CURVE"
    }
    return CurvesData(
        name=name,
        points=points,
        radius=radii(stored, len(points), DEFAULT_RADIUS),
        first=first,
        material_slot=np.zeros(len(first) - 1, np.int32),
        shape=shape,
        subdivisions=subdivisions,
        uvs=uvs,
        colors=colors(stored, needs, uvs),
        active_uv=active,
        # one by one: read all at once, their memory is freed before it is looked at
        normals=np.array([n.vector[:] for n in curves.normals], np.float32) if needs.strand_normals else None,
    )


def radii(stored, count: int, default: float):
    """(count,) of the attribute, or the same for all."""
    attribute = stored.get("radius")
    if attribute is None or attribute.data_type != "FLOAT" or len(attribute.data) != count:
        return np.full(count, default, np.float32)
    return read(attribute.data, *READ_AS["FLOAT"])


def colors(stored, needs: Needs, but) -> dict:
    """The attributes that graphs name, as (n, 4); pairs of single points among them."""
    found = sorted(((needs.colors | needs.uvs) & stored.keys()) - but.keys())
    return {
        name: four_channels(read(stored[name].data, *READ_AS[stored[name].data_type]))
        for name in found
        if stored[name].data_type in READ_AS
    }


def hair_systems(owner, viewport: bool) -> list:
    """The modifiers of an evaluated object whose particles are rendered as strands."""
    shown = "show_viewport" if viewport else "show_render"
    systems = [m for m in owner.modifiers if m.type == "PARTICLE_SYSTEM" and getattr(m, shown)]
    return [m for m in systems if is_hair(m.particle_system.settings)]


def is_hair(settings) -> bool:
    """Whether particles of these settings are strands."""
    return settings.render_type == "PATH" and settings.type == "HAIR"


def export_strands(owner, viewport: bool, needs: Needs, shape: str, subdivisions: int) -> CurvesData | None:
    """The strands of all hair systems of an evaluated object, in its own space; None where there are none."""
    parts = [System(owner, modifier, viewport) for modifier in hair_systems(owner, viewport)]
    parts = [part for part in parts if len(part.points)]
    if not parts:
        return None
    mesh = owner.data
    maps = [layer.name for layer in mesh.uv_layers]
    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    painted = [a.name for a in mesh.attributes if a.data_type == "BYTE_COLOR" and a.domain == "CORNER"]
    wanted = {name or active for name in needs.uvs} & set(maps)
    points = np.concatenate([part.points for part in parts])
    counts = np.concatenate([part.counts for part in parts])
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    generated = None
    if needs.generated:
        place, size = (np.array(v, np.float32) for v in (mesh.texspace_location, mesh.texspace_size))
        generated = (points[first[:-1]] - place) / np.where(size == 0, 1, 2 * size) + np.float32(0.5)
    return CurvesData(
        name=f"{owner.name}'s hair",
        points=points,
        radius=np.concatenate([part.radius() for part in parts]),
        first=first,
        material_slot=np.concatenate([np.full(len(p.counts), p.slot, np.int32) for p in parts]),
        shape=shape,
        subdivisions=subdivisions,
        uvs={name: np.concatenate([p.uv(maps.index(name)) for p in parts]) for name in sorted(wanted)},
        colors={
            name: np.concatenate([p.color(painted.index(name)) for p in parts])
            for name in sorted(needs.colors & set(painted))
        },
        active_uv=active,
        generated=generated,
    )


class System:
    """One hair system's strands.

    Attributes
    ----------
    points : (P, 3) float32
        In the object's space.
    counts : (C,) int
        Points of each strand.
    slot : int
        Material slot of the object.
    """

    def __init__(self, owner, modifier, viewport: bool) -> None:
        self.modifier, self.system = modifier, modifier.particle_system
        settings = self.settings = self.system.settings
        parents, children = len(self.system.particles), len(self.system.child_particles)
        share = settings.display_percentage / 100 if viewport else 1.0
        children = int(children * share)
        keeps_parents = settings.child_type == "NONE" or children == 0
        self.numbers = range(0 if keeps_parents else parents, parents + children)
        self.parents = parents
        steps = 2 ** (settings.display_step if viewport else settings.render_step) + 1
        if settings.kink == "SPIRAL":
            steps += settings.kink_extra_steps
        self.steps = steps
        self.slot = max(settings.material - 1, 0)
        hair = self.system.co_hair
        world = np.array([hair(owner, particle_no=p, step=k) for p in self.numbers for k in range(steps)])
        inverse = np.linalg.pinv(np.array(owner.matrix_world, np.float64))
        local = world.reshape(-1, 3) @ inverse[:3, :3].T + inverse[:3, 3]
        self.points = local.astype(np.float32)
        self.counts = np.full(len(self.numbers), steps, np.int64)

    def radius(self):
        """(P,) from root to tip by the settings' shape."""
        settings = self.settings
        strands = self.points.reshape(-1, self.steps, 3).astype(np.float64)
        step = np.linalg.norm(np.diff(strands, axis=1), axis=2)
        way = np.concatenate([np.zeros((len(strands), 1)), np.cumsum(step, axis=1)], axis=1)
        length = way[:, -1:]
        left = np.clip(1 - way / np.where(length > 0, length, 1), 0, 1)
        shape = settings.shape
        if shape != 0:
            with np.errstate(divide="ignore"):
                left = left ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-12))
        root, tip = settings.root_radius, settings.tip_radius
        radius = (left * (root - tip) + tip) * settings.radius_scale * 0.5
        if settings.use_close_tip:
            radius[:, -1] = 0
        return radius.reshape(-1).astype(np.float32)

    def parent(self, number: int):
        """What the functions of a strand ask for beside its number."""
        particles = self.system.particles
        return particles[min(number, self.parents - 1)]

    def uv(self, layer: int):
        """(C, 2) where on the emitter's map each strand stands."""
        on = self.system.uv_on_emitter
        rows = [on(self.modifier, particle=self.parent(n), particle_no=n, uv_no=layer) for n in self.numbers]
        return np.array(rows, np.float32).reshape(-1, 2)

    def color(self, layer: int):
        """(C, 4) the emitter's colour there, linear."""
        on = self.system.mcol_on_emitter
        rows = [
            on(self.modifier, particle=self.parent(n), particle_no=n, vcol_no=layer) for n in self.numbers
        ]
        srgb = np.array(rows, np.float64).reshape(len(rows), -1)[:, :3]
        linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        return four_channels(linear.astype(np.float32))
