"""Many view layers, many renders, many cancelled ones: what each does to time, memory and threads."""

from __future__ import annotations

import gc
import threading
import time
from pathlib import Path

import bpy
import numpy as np
from support.engine_scene import engine_scene, exr, observed, rendered

from pt_engine.blender.record import Observer, Session


def sized(scene, width: int, height: int):
    """The scene at a size in pixels."""
    scene.render.resolution_x, scene.render.resolution_y = width, height
    return scene


def seconds_of_layers(count: int, folder: Path) -> list[float]:
    """Of each view layer of a scene that has `count`, rendered one after another; each has its picture."""
    scene = engine_scene(samples=1)
    for k in range(count - 1):
        scene.view_layers.new(f"Layer {k}")
    sized(scene, 8, 8)
    exr(scene, folder / "a.exr", multilayer=True)
    started = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    whole = time.perf_counter() - started
    found = [stats["seconds"]["total"] for stats in Session.last.layers.values()]
    assert len(found) == count
    return [*found, whole]


def resident_after_renders(count: int, folder: Path) -> list[float]:
    """Bytes of this process after each of `count` times that a file is opened and rendered."""
    sized(engine_scene(samples=1), 64, 64)
    path = folder / "a.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    sizes = []
    for _ in range(count):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        bpy.ops.render.render()
        gc.collect()
        sizes.append(resident())
    assert not workers()
    return sizes


class Impatient(Observer):
    """Stops after some units of work."""

    def __init__(self, units: int) -> None:
        self.units = units

    def should_stop(self) -> bool:
        self.units -= 1
        return self.units < 0


def cancelled(count: int, folder: Path) -> int:
    """How many of `count` renders of 32 samples were stopped before their end, after 0 to 7 units of work.

    Each leaves a picture and no thread.
    """
    scene = sized(engine_scene(samples=32), 16, 8)
    scene.render.threads = 2
    stopped = 0
    for units in np.random.default_rng(0).integers(0, 8, count):
        with observed(Impatient(int(units))):
            image = rendered(scene, folder / "a.exr")
        (stats,) = Session.last.layers.values()
        stopped += stats["cancelled"]
        assert np.isfinite(image).all()
        assert image.shape == (8, 16, 4)
        assert 1 <= stats["samples"] <= 32
        assert not workers()
    return stopped


def workers() -> list[str]:
    """Names of the engine's threads."""
    return [t.name for t in threading.enumerate() if t.name.startswith("pt_engine")]


def resident() -> float:
    """Bytes of this process; 0 where the system does not say."""
    try:
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    except OSError:
        return 0.0
    return float(pages) * 4096
