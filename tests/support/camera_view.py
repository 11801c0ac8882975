"""What a camera sees, one look at the centre of each pixel: by Cycles, and by us."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from support.bpy_scenes import export
from support.exr import pixels

from pt_engine.core.raykind import RayKind
from pt_engine.scene.arrivals import Arrivals
from pt_engine.scene.lanes import Lanes
from pt_engine.scene.prepare import prepare
from pt_engine.scene.wave import Rays

SIZE = 64


def one_sample(scene):
    """Set Cycles to look once at each pixel's centre and to store what it finds unchanged."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    scene.cycles.max_bounces = 0
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth, scene.render.image_settings.exr_codec = "32", "NONE"


def cycles(scene):
    """(3, n) Cycles' picture, bottom row first."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "picture.exr")
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return np.ascontiguousarray(pixels(path)[..., :3].reshape(-1, 3).T)


def shot(ready, sample):
    """(3, n) our emission, `sample` (x, y) of a pixel from its lower left corner."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    raster = (np.stack([x.ravel(), y.ravel()]) + np.reshape(sample, (-1, 1))).astype(np.float32)
    rays = ready.camera.at_resolution(SIZE, SIZE).rays(raster)
    rays = Rays(rays.o, rays.d, rays.tfar)
    found = ready.intersect(rays)
    radius, spread = ready.camera.footprint(rays.d)
    out = np.zeros((3, SIZE * SIZE), np.float32)
    for smooth in (False, True):
        on = ready.geometry.surface_smooth.take(found.surface) == smooth
        lanes = np.flatnonzero(on & (ready.geometry.surface_material.take(found.surface) > 0))
        if len(lanes) == 0:
            continue
        came = Arrivals.by(RayKind.CAMERA, len(lanes))
        came = came._replace(radius=radius.take(lanes), spread=spread.take(lanes))
        here = Lanes(ready, ready.surface(rays, found, lanes), came, smooth)
        batch = ready.materials.batches[ready.materials.batch_of[here.material[0]]]
        value = batch.emission(here)
        if value is not None:
            out[:, lanes] = value
    return out


def ours(sample=0.5):
    """(3, n) our emission at the pixels' centres."""
    return shot(prepare(export()).with_pixels(SIZE, SIZE), (sample, sample))
