"""A peer's error against time: `python -m bench.gallery_peers PEER FILE REFERENCE SECONDS`.

REFERENCE is an .npz of `mean` and `variance`, top row first. One JSON line: for each number of samples the
mean squared error and the core seconds of so many samples, from the difference of a long and a short
render, so that loading, building and start-up cancel out, as in `bench.peers`.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pt_engine.report.errors import Picture, mse
from pt_engine.report.pictures import picture_of

from .gallery_scenes import SHOWN
from .peers import CYCLES_PLAIN, mitsuba_dict
from .shapes import MODELS, Frame

LONGEST = 1024  # samples


def measured(
    render: Callable[[int, int], np.ndarray], reference: Picture, limit: float
) -> list[dict[str, float]]:
    """Points of a `render(samples, seed)`, which gives (height, width, 3) with the top row first.

    The longest takes about `limit` core seconds.
    """
    points: list[tuple[int, float, float, float]] = []
    mean = float(reference.mean.mean())
    samples = 1
    while samples <= LONGEST:
        started = time.process_time()
        image = render(samples, samples)
        seconds = time.process_time() - started
        energy = float(image.mean(dtype=np.float64)) / mean - 1
        points.append((samples, seconds, mse(image.astype(np.float64), reference), energy))
        if seconds - points[0][1] > limit / 2:  # without what every render costs
            break
        samples *= 2
    (few, short, *_), (many, long, *_) = points[0], points[-1]
    each = (long - short) / max(many - few, 1)
    return [{"samples": n, "seconds": n * each, "mse": error, "energy": e} for n, _, error, e in points]


def mitsuba_points(blend: Path, reference: Picture, limit: float) -> list[dict[str, float]]:
    """Mitsuba's scalar_rgb on this process's core."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    shown = SHOWN[blend.stem]
    frame = Frame(shown.width, shown.height, shown.max_depth)
    scene = mitsuba.load_dict(mitsuba_dict(MODELS[blend.stem](), frame))

    def render(samples: int, seed: int) -> np.ndarray:
        return np.array(mitsuba.render(scene, spp=samples, seed=seed))[..., :3]

    return measured(render, reference, limit)


def cycles_points(blend: Path, reference: Picture, limit: float) -> list[dict[str, float]]:
    """Cycles, one thread, nothing but path tracing."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene, shown = bpy.context.scene, SHOWN[blend.stem]
    scene.render.engine, scene.render.threads_mode, scene.render.threads = "CYCLES", "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = shown.width, shown.height
    scene.render.use_compositing = scene.render.use_sequencer = False
    bounces = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces")
    for name, value in (CYCLES_PLAIN | dict.fromkeys(bounces, shown.max_depth - 2)).items():
        setattr(scene.cycles, name, value)
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR", "32"

    with tempfile.TemporaryDirectory() as folder:

        def render(samples: int, seed: int) -> np.ndarray:
            scene.cycles.samples, scene.cycles.seed = samples, seed
            bpy.ops.render.render()
            path = Path(folder) / "image.exr"
            bpy.data.images["Render Result"].save_render(str(path), scene=scene)
            return picture_of(path).mean

        return measured(render, reference, limit)


def main(peer: str, blend: Path, reference: Path, limit: float) -> None:
    """Print the points."""
    arrays: Any = np.load(reference)
    known = Picture(arrays["mean"], arrays["variance"])
    print(json.dumps({"cycles": cycles_points, "mitsuba": mitsuba_points}[peer](blend, known, limit)))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]), float(sys.argv[4]))
