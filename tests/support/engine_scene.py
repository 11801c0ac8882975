"""A small lit scene set up for PT Engine, and its render read back."""

from contextlib import contextmanager
from pathlib import Path

import bpy
from support.bpy_scenes import add, cube, empty_scene
from support.exr import pixels

from pt_engine.blender import registration
from pt_engine.blender.record import Observer, Session

WIDTH, HEIGHT = 32, 24


def engine_scene(samples=2):
    """A cube under a point light before a grey world; the camera sees sky all around it."""
    scene = empty_scene()
    registration.register()
    scene.render.engine = "PT_ENGINE"
    scene.camera.location = (0, 0, 6)
    add(cube(), "Cube")
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy = 200
    add(lamp, location=(2, 2, 4))
    world = scene.world = bpy.data.worlds.new("World")
    if not world.node_tree:
        world.use_nodes = True
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.pt_engine.samples = samples
    scene.pt_engine.max_depth = 3
    return scene


def exr(scene, path, multilayer=False):
    """Set the scene to write 32-bit EXR files to `path`."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    if not multilayer:
        image.color_mode = "RGBA"
    image.color_depth = "32"
    scene.render.filepath = str(path)


def rendered(scene, path):
    """(rows, columns, 4) float32 of a render written to `path`, bottom row first."""
    exr(scene, path)
    bpy.ops.render.render(write_still=True)
    return pixels(path)


@contextmanager
def observed(observer: Observer):
    """`observer` follows the renders inside."""
    before, Session.observer = Session.observer, observer
    try:
        yield observer
    finally:
        Session.observer = before


class Recorder(Observer):
    """Keeps what it is told; stops after `patience` units of work."""

    def __init__(self, patience=None):
        self.patience, self.units, self.warnings, self.failures = patience, 0, [], []

    def on_warning(self, headline, lines):
        self.warnings.append((headline, lines))
        return True

    def on_progress(self, progress):
        self.units += 1

    def should_stop(self):
        return self.patience is not None and self.units >= self.patience

    def on_failure(self, message):
        self.failures.append(message)


def integrator_file(folder: Path, name: str, body: str) -> Path:
    """A user's file with one integrator whose `sample` is `body`."""
    path = folder / f"{name}.py"
    lines = "\n".join("        " + line for line in body.splitlines())
    path.write_text(
        "import numpy as np\n"
        "from pt_engine.render.integrator import Integrator\n\n\n"
        f"class Mine(Integrator):\n    name = {name!r}\n    label = 'Mine'\n\n"
        f"    def sample(self, scene, rays, sampler):\n{lines}\n"
    )
    return path
