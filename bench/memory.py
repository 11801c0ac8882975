"""What a render needs beyond what Blender itself holds: bytes per triangle, per pixel and per thread.

Each case is a process of its own (`python -m bench.memory TRIANGLES WIDTH THREADS`): Blender opens
with a grid of that many triangles, and only what the export, the scene and the render add is counted,
at its peak. Differences between cases give the slopes.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from . import machine

LIMITS = {"per_million_triangles": 150e6, "per_pixel": 150.0, "per_thread": 80e6}


def memory() -> dict[str, float]:
    """The three slopes, in bytes."""
    small, large = case(500_000), case(2_500_000)
    few, many = case(2_000, width=256), case(2_000, width=2048)
    one, two = case(200_000, width=512), case(200_000, width=512, threads=2)
    return {
        "per_million_triangles": (large["peak"] - small["peak"]) / 2,
        "per_million_triangles_kept": (large["kept"] - small["kept"]) / 2,
        "per_pixel": (many["peak"] - few["peak"]) / (2048**2 - 256**2),
        "per_thread": two["peak"] - one["peak"],
    }


def case(triangles: int, width: int = 256, threads: int = 1) -> dict[str, float]:
    """Run one case in a new process."""
    output, _ = machine.run(["bench.memory", str(triangles), str(width), str(threads)], cores=threads)
    found: dict[str, float] = json.loads(output.splitlines()[-1])
    return found


def measure(triangles: int, width: int, threads: int) -> dict[str, float]:
    """Resident bytes that an export and a render add: at the peak, and while the scene is kept."""
    import bpy

    from pt_engine.blender.export.scene import export_scene
    from pt_engine.render import integrators  # noqa: F401  fills the registry
    from pt_engine.render.progressive import render
    from pt_engine.render.settings import RenderSettings
    from pt_engine.scene.prepare import prepare

    grid(bpy, triangles)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    before = resident("VmRSS")
    reset_peak()
    snapshot = export_scene(depsgraph)
    scene = prepare(snapshot)
    kept = resident("VmRSS")
    del snapshot
    result = render(scene, RenderSettings(width, width, samples=2 * threads, threads=threads, max_depth=4))
    result.image()
    return {"peak": resident("VmHWM") - before, "kept": kept - before}


def grid(bpy: Any, triangles: int) -> None:
    """An empty file with a bumpy grid, a sky and a camera."""
    from .scenes import build
    from .shapes import FRAMES, hills

    edge = round((triangles / 2) ** 0.5) + 1
    build(hills(edge), FRAMES["S4"])


def resident(key: str) -> float:
    """VmRSS or VmHWM of this process, in bytes."""
    with open("/proc/self/status", encoding="ascii") as file:
        for line in file:
            if line.startswith(key):
                return float(line.split()[1]) * 1024
    raise OSError("this system does not tell a process's memory")


def reset_peak() -> None:
    """Start VmHWM anew."""
    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")


if __name__ == "__main__":
    print(json.dumps(measure(*(int(x) for x in sys.argv[1:]))))
