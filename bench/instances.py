"""Three ways to place instances, side by side: start, memory, and time per ray.

`python -m bench.instances` writes docs/instances.md. Each case is a process of its own (`python -m
bench.instances SCENE WAY`); with PT_SCENES set, an artist's file of 7,659 instances is among them.
"""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import machine
from .memory import reset_peak, resident

WAYS = ("plain", "copied", "nested")
COUNTS = {"100 balls": 100, "400 balls": 400}
ARTISTS = Path(os.environ.get("PT_SCENES", "")) / "graphene-device" / "device.blend"
GRAPHENE = "graphene device"
TEXT = """# Instances

`python -m bench.instances` writes this page.

embreex gives no access to Embree's instances: a scene takes triangle meshes only, several of them, and says
which was hit; there are no flags but "robust" (which is on), no compact or quantised trees, no shared
buffers. Reaching past it would not help: its loop over rays drops the number of the instance that was hit.
So there are three ways to place a mesh that occurs often (`scene/instancing.py`):

- **plain**: its triangles get records of their own (normal, plane, error bound) in the world;
- **copied**: Embree holds its triangles in the world, while records are the mesh's, in object space; a
  hit's normal and plane go through the instance's matrix;
- **nested**: it is not placed at all. A tree of the instances' boxes, eight children a node, is walked with
  numpy, and each ray is taken to the meshes whose boxes it runs through, nearest first.

{table}

*Build* and *memory* are what preparing the scene takes. *Start* is all CPU time until the first sample can be
drawn, with Python, Blender, opening and exporting the file; *process* is the most that the process ever held,
the render included.

Copies build in half the time, since embreex reads a mesh's indices once for all of them, and need a
seventh less memory; a ray takes 5 to 20 % longer. Nested instances need next to nothing and start at once,
but a ray takes three to ten times as long, the more, the more of them stand one behind another. So meshes
that occur several times are copied where that concerns half a million triangles or more, and nested, those
that spare most first, only where the scene would not fit in the memory that is free (or that *Memory
Limit* allows). What would not fit even so is refused before the build, with the numbers. Instances that
move while the shutter is open, or that some rays do not see, are plain, too.

Emitters, instances whose material looks at its own object (bevel, local ambient occlusion), flattened ones
(one axis below a thousandth of another) and meshes with vertices that are not finite stay plain.
"""


def snapshot_of(scene: str) -> Any:
    """Balls of 7,900 triangles in a cube, or the artist's file."""
    from pt_engine.selftest import scenes as make

    if scene == GRAPHENE:
        import bpy

        from pt_engine.blender.export import export_scene

        bpy.ops.wm.open_mainfile(filepath=str(ARTISTS))
        return export_scene(bpy.context.evaluated_depsgraph_get())
    count, rng = COUNTS[scene], np.random.default_rng(0)
    ball, edge = make.sphere(1.0, 45, smooth=False), 2.5 * round(COUNTS[scene] ** (1 / 3))
    places = [make.translation(*rng.uniform(-edge / 2, edge / 2, 3)) for _ in range(count)]
    camera = make.perspective((0, -edge, 0), (0, 0, 0))
    snapshot = make.scene([(ball, at, make.diffuse(0.6)) for at in places], camera, sky=make.world(1.0))
    same = replace(snapshot.instances, mesh=np.zeros(count, np.int32))
    return replace(snapshot, meshes=(ball,), instances=same)


def measure(scene: str, way: str) -> dict[str, float]:
    """CPU seconds and bytes of the build and of the whole process, nanoseconds per ray."""
    from pt_engine.nodes.compile import compile_materials
    from pt_engine.render import integrators  # noqa: F401  fills the registry
    from pt_engine.render.progressive import render
    from pt_engine.render.settings import RenderSettings
    from pt_engine.scene import prepare as preparing
    from pt_engine.scene.placing import may_share

    snapshot = snapshot_of(scene)
    sharing = may_share(snapshot, compile_materials(snapshot.materials), [])
    if sharing is not None:
        sharing.nested[:] = way == "nested"
    preparing.sharing_that_fits = lambda *_: None if way == "plain" else sharing  # type: ignore[attr-defined]
    before = resident("VmRSS")
    reset_peak()
    started = time.process_time()
    prepared = preparing.prepare(snapshot)
    build, start = time.process_time() - started, time.process_time()
    peak = resident("VmHWM") - before
    settings = RenderSettings(160, 90, samples=16, threads=1, max_depth=4)
    started = time.process_time()
    progress = render(prepared, settings).progress
    ray = (time.process_time() - started) / sum(progress.rays.values())
    triangles = sum(len(snapshot.meshes[m].triangles) for m in snapshot.instances.mesh)
    whole = resident("VmHWM")
    return {
        "triangles": triangles, "build": build, "start": start, "peak": peak, "whole": whole, "ns": 1e9 * ray
    }  # fmt: skip


def main() -> None:
    """Run all cases and write the page."""
    rows = [
        "| scene | triangles | way | build, CPU s | start, CPU s | memory, MB | process, MB | ns a ray |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for scene in [*COUNTS, *([GRAPHENE] if ARTISTS.is_file() else [])]:
        for way in WAYS:
            output, _ = machine.run(["bench.instances", scene, way])
            m = json.loads(output.splitlines()[-1])
            seconds = f"{m['build']:.1f} | {m['start']:.1f}"
            memory = f"{m['peak'] / 1e6:,.0f} | {m['whole'] / 1e6:,.0f}"
            rows.append(f"| {scene} | {m['triangles']:,} | {way} | {seconds} | {memory} | {m['ns']:,.0f} |")
    page = TEXT.format(table="\n".join(rows))
    (machine.ROOT / "docs" / "instances.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        print(json.dumps(measure(*sys.argv[1:])))
    else:
        main()
