"""What a moment of the shutter costs: what moves in a tree of its own, or everything built anew.

A floor of bumps that stands still, and balls that move over it under a grey sky. *Slice* is what `Slices.at`
takes for one moment, *whole* the placing, Embree's build and the records of all triangles, which it replaces;
both in CPU time, the best of some. *One tree* and *two trees* are what a sample (six edges at most) takes in
the scene standing still and in a slice of it, without the building: rays are sent through both trees. Memory
is what each slice that is kept adds to the process.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pt_engine.core.memory import kept_buffers
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.accel import Accel
from pt_engine.scene.geometry import pack, place
from pt_engine.scene.movement import moving_last
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import InstanceMotion, Instances, MeshMotion, Motion, Snapshot
from pt_engine.selftest import scenes as make

from . import machine
from .memory import resident
from .report import machine_text, table

REPEATS, KEPT = 5, 8
SETTINGS = RenderSettings(256, 256, samples=4, threads=1, max_depth=6)


class Case(NamedTuple):
    """Triangles of the floor, number of balls, rings of each, and whether they change their shape."""

    floor: int
    balls: int
    rings: int
    deform: bool = False


CASES = {
    "one small ball": Case(500_000, 1, 16),
    "a fine ball": Case(500_000, 1, 250),
    "a fine ball that changes shape": Case(500_000, 1, 250, True),
    "1,000 balls": Case(500_000, 1_000, 12),
    "nearly everything": Case(10_000, 4, 250),
}


class Row(NamedTuple):
    """What was measured of a case; times in seconds, memory in bytes."""

    moving: int
    still: int
    slice: float
    whole: float
    one: float
    two: float
    memory: float


def main() -> None:
    """Measure, and write docs/motion-blur.md."""
    machine.pin()
    rows = {name: measured(case) for name, case in CASES.items()}
    (machine.ROOT / "docs" / "motion-blur.md").write_text(page(rows), encoding="utf-8")


def page(rows: dict[str, Row]) -> str:
    """A line for each case."""
    header = ["what moves", "triangles that move", "that stand", "slice, ms", "whole, ms", "times as fast",
              "one tree, ns", "two trees, ns", "ratio", "MB a slice"]  # fmt: skip
    lines = [
        [name, f"{r.moving:,}", f"{r.still:,}", f"{1e3 * r.slice:.1f}", f"{1e3 * r.whole:.1f}",
         f"{r.whole / r.slice:.1f} ×", f"{1e9 * r.one:.0f}", f"{1e9 * r.two:.0f}", f"{r.two / r.one:.2f} ×",
         f"{r.memory / 1e6:.1f}"]
        for name, r in rows.items()
    ]  # fmt: skip
    text, made = (__doc__ or "").strip(), "Made by `python -m bench.motion`; not edited by hand."
    described = machine_text(machine.description())
    return "\n\n".join(["# Motion blur", made, described, text, table(header, lines)]) + "\n"


def measured(case: Case) -> Row:
    """One case."""
    snapshot = flying(case)
    scene = prepare(snapshot)
    slices = scene.slices
    assert slices is not None
    times = iter(np.random.default_rng(0).uniform(size=1000))
    ordered = moving_last(snapshot)

    def whole() -> Any:
        placed = place(ordered)
        return Accel(placed.vertices, placed.triangles), pack(ordered, placed)

    there = slices.at(0.5)
    there.slices = None
    still = prepare(replace(snapshot, motion=None))
    one, two = (best(lambda scene=scene: render(scene, SETTINGS)) for scene in (still, there))
    samples = SETTINGS.width * SETTINGS.height * SETTINGS.samples
    took = best(lambda: slices.at(next(times)))
    before = resident("VmRSS")
    kept = [slices.at(next(times)) for _ in range(KEPT)]
    memory = (resident("VmRSS") - before) / len(kept)
    total = len(scene.geometry.records) - 1
    row = slices.triangles, total - slices.triangles, took, best(whole)
    return Row(*row, one / samples, two / samples, memory)


def best(work: Callable[[], Any]) -> float:
    """CPU seconds of the quickest of some runs."""
    found = np.inf
    with kept_buffers():
        for _ in range(REPEATS):
            started = time.process_time()
            work()
            found = min(found, time.process_time() - started)
    return float(found)


def flying(case: Case) -> Snapshot:
    """The scene of a case."""
    edge = round((case.floor / 2) ** 0.5) + 1
    x, y = np.meshgrid(np.linspace(-5, 5, edge), np.linspace(-5, 5, edge))
    z = 0.2 * np.sin(7 * x) * np.cos(5 * y)
    a = (np.arange(edge - 1)[:, None] * edge + np.arange(edge - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + edge + 1], 1), np.stack([a, a + edge + 1, a + edge], 1)])
    floor = make.mesh(np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces, name="floor")
    ball = make.sphere(1.0, case.rings)
    random = np.random.default_rng(1)
    size = 1.2 / case.balls ** (1 / 3)
    places = (
        random.uniform((-3, -3, 1), (3, 3, 3), (case.balls, 3)) if case.balls > 1 else np.array([[0, 0, 1.5]])
    )
    steps = np.zeros((case.balls, 3, 4, 4))
    steps[..., :3, :3] = np.eye(3) * size
    steps[..., 3, 3] = 1
    steps[..., :3, 3] = places[:, None] + np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0]])
    made = make.scene(
        [(floor, np.eye(4), make.diffuse(0.5)), (ball, np.eye(4), make.diffuse(0.8, "ball"))],
        make.perspective((0, -9, 6), (0, 0, 0), 0.5), sky=make.world(1.0),
    )  # fmt: skip
    motion = Motion(
        np.ones(2, np.float32), (InstanceMotion(np.arange(1, case.balls + 1, dtype=np.int32), steps),)
    )
    if case.deform:
        shapes = np.stack([ball.vertices * np.float32([1, 1, s]) for s in (0.5, 1, 1.5)])
        motion = replace(motion, meshes=(MeshMotion(1, shapes, np.stack([ball.normals] * 3)),))
    return replace(made, instances=placed_balls(made.instances, steps[:, 1]), motion=motion)


def placed_balls(rows: Instances, matrix: Any) -> Instances:
    """The floor, and the ball as often as there are matrices."""
    n = len(matrix)
    index = np.concatenate([[0], np.ones(n, int)])
    return Instances(
        rows.mesh[index], np.concatenate([rows.matrix[:1], matrix]), rows.materials[index],
        rows.random[index], rows.color[index], rows.pass_index[index], rows.visibility[index],
        ("floor", *["ball"] * n),
    )  # fmt: skip


if __name__ == "__main__":
    main()
