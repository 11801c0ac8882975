"""One case in a process of its own: what a render was said to need, and what it has taken at its peak.

python -m support.measured_memory CASE        prints {"estimate": bytes, "peak": bytes}
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from pt_engine.nodes.compile import compile_materials
from pt_engine.render.memory import image_bytes
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.memory import need
from pt_engine.scene.placing import may_share
from pt_engine.scene.prepare import prepare

from . import scenes as make

CAMERA = make.perspective((0, -3, 0), (0, 0, 0))
GREY = make.diffuse(0.5)
SMALL = RenderSettings(64, 64, samples=4, threads=1)


def hills(edge: int):
    """A smooth grid of 2 (edge − 1)² triangles."""
    x, y = (c.ravel() for c in np.meshgrid(*[np.linspace(-1, 1, edge)] * 2, indexing="ij"))
    first = (np.arange(edge - 1)[:, None] * edge + np.arange(edge - 1)).ravel()
    lower = np.stack([first, first + 1, first + edge], axis=1)
    triangles = np.concatenate([lower, lower + [[1, edge, 0]]])
    up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    return make.mesh(np.stack([x, y, 0.1 * np.sin(9 * x + 5 * y)], axis=1), triangles, up)


def one_mesh():
    """2.4 million triangles."""
    return make.scene([(hills(1100), np.eye(4), GREY)], CAMERA, sky=make.world(1.0)), SMALL


def many_copies():
    """300 instances of 9,500 triangles."""
    mesh = hills(70)
    rows = [(mesh, make.translation(k % 10, k // 10, 0), GREY) for k in range(300)]
    snapshot = make.scene(rows, CAMERA, sky=make.world(1.0))
    same = replace(snapshot.instances, mesh=np.zeros(300, np.int32))
    return replace(snapshot, meshes=(mesh,), instances=same), SMALL


def large_image():
    """4 million pixels."""
    ball = make.sphere(1.0, 32)
    snapshot = make.scene([(ball, np.eye(4), GREY)], CAMERA, sky=make.world(1.0))
    return snapshot, replace(SMALL, width=2048, height=2048, samples=2, max_depth=3)


CASES = {"one mesh": one_mesh, "many copies": many_copies, "large image": large_image}


def measure(case: str) -> dict[str, float]:
    """Estimate and peak in bytes, beyond what the process had when the snapshot was made."""
    snapshot, settings = CASES[case]()
    warm = make.scene([(make.box(), np.eye(4), GREY)], CAMERA, sky=make.world(1.0))
    render(prepare(warm), replace(SMALL, width=8, height=8))  # ends with what is free given back
    materials = compile_materials(snapshot.materials)
    needed = need(snapshot, may_share(snapshot, materials, []), materials.needs)
    before = resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # VmHWM starts anew
    result = render(prepare(snapshot), settings)
    pictures = [result.image() for _ in range(3)]  # one, and two for Blender's copies
    peak = resident("VmHWM") - before
    assert all(picture.any() for picture in pictures)
    return {"estimate": max(needed.building, needed.kept + image_bytes(settings)), "peak": peak}


def resident(key: str) -> float:
    """VmRSS or VmHWM of this process, in bytes."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) * 1024 for line in lines if line.startswith(key))


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1])))
