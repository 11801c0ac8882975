"""The engine's own panels. Most are rows of a table: a panel is a name and the properties it shows."""

from __future__ import annotations

import bpy

from .compatibility import ENGINE
from .record import Session
from .settings import adapts
from .words import count, duration, estimated_error
from .wrapping import listing

LINES = 24  # of a listing

OWN, RENDER, CYCLES, CURVES = "pt_engine", "render", "cycles", "cycles_curves"

# name, label, closed, rows of (owner, property)
PROPERTY_PANELS = (
    (
        "sampling",
        "Sampling",
        False,
        ((OWN, "integrator"), (OWN, "samples"), (OWN, "seconds"), (OWN, "seed"), (OWN, "sampler")),
    ),
    (
        "target",
        "Target Error",
        False,
        (
            (OWN, "target_percent"),
            (OWN, "target_of"),
            (OWN, "target_percentile"),
            (OWN, "min_samples"),
            (OWN, "adaptive"),
        ),
    ),
    (
        "light_paths",
        "Light Paths",
        False,
        (
            *((OWN, "max_depth"), (OWN, "rr_depth"), (OWN, "transparent_depth")),
            *((OWN, "clamp_direct"), (OWN, "clamp_indirect")),
        ),
    ),
    (
        "motion_blur",
        "Motion Blur",
        True,
        (
            (RENDER, "use_motion_blur"),
            (RENDER, "motion_blur_position"),
            (RENDER, "motion_blur_shutter"),
            (CYCLES, "rolling_shutter_type"),
            (CYCLES, "rolling_shutter_duration"),
        ),
    ),
    (
        "subdivision",
        "Subdivision",
        True,
        ((CYCLES, "dicing_rate"), (CYCLES, "offscreen_dicing_scale"), (CYCLES, "max_subdivisions")),
    ),
    ("curves", "Curves", True, ((CURVES, "shape"), (CURVES, "subdivisions"))),
    (
        "film",
        "Film",
        True,
        (
            (CYCLES, "film_exposure"),
            (RENDER, "film_transparent"),
            (OWN, "pixel_filter"),
            (OWN, "filter_width"),
        ),
    ),
    (
        "performance",
        "Performance",
        True,
        ((RENDER, "threads_mode"), (RENDER, "threads"), (OWN, "texture_memory"), (OWN, "memory_limit")),
    ),
    (
        "simplify",
        "Simplify",
        True,
        (
            (RENDER, "use_simplify"),
            (RENDER, "simplify_subdivision_render"),
            (RENDER, "simplify_child_particles_render"),
        ),
    ),
)


class RenderPanel:
    """A panel of the render properties."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = frozenset({ENGINE})

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def property_panel(name, label, closed, rows):
    """A panel class that shows the properties of a table row."""

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for owner, prop in rows:
            data = getattr(context.scene, owner, None)
            if hasattr(data, prop):
                row = layout.row()
                row.active = is_active(context.scene, prop)
                row.prop(data, prop)

    return type(
        f"PTENGINE_RENDER_PT_{name}",
        (RenderPanel, bpy.types.Panel),
        {
            "bl_label": label,
            "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
            "draw": draw,
        },
    )


def is_active(scene, prop: str) -> bool:
    """Whether a property has an effect with the others as they are."""
    if prop == "filter_width":
        return scene.pt_engine.pixel_filter not in ("FILE", "BOX")
    if prop == "target_of":
        return scene.pt_engine.target_error > 0
    if prop == "target_percentile":
        return scene.pt_engine.target_error > 0 and scene.pt_engine.target_of == "PIXELS"
    if prop == "adaptive":
        return adapts(scene.pt_engine)
    if prop == "min_samples":
        return scene.pt_engine.target_error > 0 or (scene.pt_engine.adaptive and adapts(scene.pt_engine))
    if prop == "rolling_shutter_duration" and scene.cycles.rolling_shutter_type == "NONE":
        return False
    if prop.startswith(("motion_blur", "rolling_shutter")):
        return scene.render.use_motion_blur
    if prop.startswith("simplify"):
        return scene.render.use_simplify
    if prop == "subdivisions":
        return scene.cycles_curves.shape == "RIBBONS"
    if prop == "threads":
        return scene.render.threads_mode == "FIXED"
    return True


class PTENGINE_RENDER_PT_integrator_files(RenderPanel, bpy.types.Panel):
    bl_label = "Integrators of Your Own"
    bl_parent_id = "PTENGINE_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        self.layout.prop(context.scene.pt_engine, "python_files", text="")
        self.layout.operator("pt_engine.load_integrators", icon="FILE_REFRESH")


class PTENGINE_RENDER_PT_statistics(RenderPanel, bpy.types.Panel):
    bl_label = "Statistics"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.scene.pt_engine, "stats_path")
        record = Session.last
        if record is None:
            layout.label(text="Nothing is rendered yet")
        elif record.failure:
            listing(layout, context, record.failure.splitlines()[:LINES], icon="ERROR")
        else:
            listing(layout, context, statistics_lines(record.statistics()))


def statistics_lines(stats) -> list[str]:
    """The last render in a few lines."""
    if not stats:
        return ["Nothing is rendered yet"]
    seconds = stats["seconds"]
    lines = [
        f"{stats['samples']} samples, {duration(seconds['total'])}",
        ", ".join(f"{name} {duration(seconds[name])}" for name in ("export", "build", "render")),
        f"{count(stats['camera_samples_per_second'])} samples/s, {count(stats['rays_per_second'])} rays/s",
        f"{stats['peak_memory_bytes'] / 2**20:.0f} MiB at most",
    ]
    if error := estimated_error(stats["error"]):
        lines.append("Error " + error)
    if dropped := stats["nonfinite"]["count"]:
        lines.append(f"{dropped} non-finite samples dropped")
    return lines + [f"{name}: {state}" for name, state in stats["features"].items()]


PROPERTY_CLASSES = tuple(property_panel(*row) for row in PROPERTY_PANELS)
CLASSES = (
    *PROPERTY_CLASSES,
    PTENGINE_RENDER_PT_integrator_files,
    PTENGINE_RENDER_PT_statistics,
)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
