"""The peers on the same models, each in a process of its own: `python -m bench.peers mitsuba|cycles FILE`.

Each prints one JSON line with camera samples per second of the render alone: the difference between a
long and a short render, so that loading, building and start-up cancel out.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from .shapes import FRAMES, MODELS, RR_DEPTH, Ball, Frame, Model, Part, View

SHORT, LONG = 4, 36
CYCLES_PLAIN = {
    "device": "CPU",
    "use_adaptive_sampling": False,
    "use_denoising": False,
    "use_guiding": False,
    "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 0.0,
    "light_sampling_threshold": 0.0,
    "blur_glossy": 0.0,
}


def pace(render: Any, frame: Frame) -> float:
    """Camera samples per second of `render(samples)`, without what every render costs."""
    seconds = []
    for samples in (SHORT, SHORT, LONG):
        started = time.perf_counter()
        render(samples)
        seconds.append(time.perf_counter() - started)
    return (LONG - SHORT) * frame.width * frame.height / (seconds[2] - min(seconds[:2]))


def mitsuba_pace(blend: Path) -> dict[str, Any]:
    """Mitsuba's scalar_rgb: one ray at a time, with Embree if its wheel has it."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    frame = FRAMES[blend.stem]
    scene = mitsuba.load_dict(mitsuba_dict(MODELS[blend.stem](), frame))
    image = None

    def render(samples: int) -> None:
        nonlocal image
        image = mitsuba.render(scene, spp=samples)

    found = pace(render, frame)
    mean = np.array(image).reshape(-1, 3).mean(axis=0)
    return {"samples_per_second": found, "mean": mean.tolist(), "version": mitsuba.__version__}


def cycles_pace(blend: Path) -> dict[str, Any]:
    """Cycles in the bpy wheel, one thread, nothing but path tracing."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene, frame = bpy.context.scene, FRAMES[blend.stem]
    scene.render.engine, scene.render.threads_mode, scene.render.threads = "CYCLES", "FIXED", 1
    bounces = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces")
    for name, value in (CYCLES_PLAIN | dict.fromkeys(bounces, frame.max_depth - 2)).items():
        setattr(scene.cycles, name, value)

    def render(samples: int) -> None:
        scene.cycles.samples = samples
        bpy.ops.render.render()

    return {"samples_per_second": pace(render, frame), "version": bpy.app.version_string}


def mitsuba_dict(model: Model, frame: Frame) -> dict[str, Any]:
    """A model as `mitsuba.load_dict` takes it."""
    import mitsuba

    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": frame.max_depth, "rr_depth": RR_DEPTH - 1},
        "sensor": _sensor(model.view, frame),
    }
    for k, part in enumerate(model.parts):
        scene[f"part{k}"] = _part(part)
    for k, ball in enumerate(model.balls):
        scene[f"ball{k}"] = _ball(ball)
    if model.sky is not None:
        rows = [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]  # its +Y is our +Z
        place = mitsuba.ScalarTransform4f(np.array(rows, float))
        scene["sky"] = {"type": "envmap", "bitmap": mitsuba.Bitmap(model.sky), "to_world": place}
    return scene


def _sensor(view: View, frame: Frame) -> dict[str, Any]:
    import mitsuba

    look = mitsuba.ScalarTransform4f().look_at(origin=view.eye, target=view.target, up=view.up)
    film = {"type": "hdrfilm", "width": frame.width, "height": frame.height, "rfilter": {"type": "box"}}
    return {
        "type": "perspective",
        "fov": float(np.degrees(view.fov)),
        "fov_axis": "x",
        "to_world": look,
        "near_clip": 0.01,
        "film": film,
        "sampler": {"type": "independent"},
    }


def _rgb(value: tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(x) for x in value]}


def _part(part: Part) -> Any:
    import mitsuba

    bsdf: dict[str, Any] = {"type": "diffuse", "reflectance": _rgb(part.colour)}
    if part.roughness is not None:
        bsdf = {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": part.roughness**2,
            "material": "none",
            "specular_reflectance": _rgb(part.colour),
        }
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict({"type": "twosided", "bsdf": bsdf})
    if part.emission is not None:
        properties["emitter"] = mitsuba.load_dict({"type": "area", "radiance": _rgb(part.emission)})
    properties["face_normals"] = True
    mesh = mitsuba.Mesh("part", len(part.vertices), len(part.triangles), props=properties)
    arrays = mitsuba.traverse(mesh)
    arrays["vertex_positions"] = np.ravel(part.vertices).astype(np.float32)
    arrays["faces"] = np.ravel(part.triangles).astype(np.uint32)
    arrays.update()
    return mesh


def _ball(ball: Ball) -> dict[str, Any]:
    """A lamp of P watts and radius r shines with P / (4π² r²)."""
    radiance = ball.power / (4 * np.pi**2 * ball.radius**2)
    return {
        "type": "sphere",
        "center": list(ball.centre),
        "radius": ball.radius,
        "bsdf": {"type": "diffuse", "reflectance": _rgb((0, 0, 0))},
        "emitter": {"type": "area", "radiance": _rgb((radiance,) * 3)},
    }


if __name__ == "__main__":
    measure = {"mitsuba": mitsuba_pace, "cycles": cycles_pace}[sys.argv[1]]
    print(json.dumps(measure(Path(sys.argv[2]))))
