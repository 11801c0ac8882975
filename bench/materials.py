"""What shading costs by number of nodes and of materials, and shader-heavy files against Cycles.

`python -m bench materials` writes docs/materials-speed.md, in about three minutes of a quiet core. A file's
two renderers take turns in one pinned process of its own (`python -m bench.materials FILE WIDTH HEIGHT`), one
thread each, timed in CPU seconds: the difference between a long and a short render, so that loading, building
and start-up cancel out.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pt_engine.core.memory import kept_buffers
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.probe import ProbeLanes, sheet
from pt_engine.scene.shading import Scattered, SliceBSDF
from pt_engine.scene.snapshot import Graph, Link, Node

from . import machine

SIDE = 256  # lanes are the square of it
REPEATS = 5
NODES = (1, 3, 10, 30, 100)
MATERIALS = (1, 10, 300)
FILES = {
    "nodevember-planet": (160, 90),
    "nodevember-snow": (160, 90),
    "nodevember-reptile": (320, 180),
    "nodevember-flower": (160, 160),
    "ignis-principled": (320, 320),
}
SHORT, LONG = 4, 24  # samples per pixel
ROUNDS = 3  # of both renderers
DEPTH = 14  # edges


def materials() -> dict[str, Any]:
    """All figures of the page."""
    machine.pin()
    with kept_buffers():
        results: dict[str, Any] = {
            "nodes": {n: shading([chain(n)]) for n in NODES},
            "plain": {n: shading([plain(k) for k in range(n)]) for n in MATERIALS},
            "mixed": {n: shading([mixed(k) for k in range(n)]) for n in MATERIALS},
        }
    sys.path.insert(0, str(machine.ROOT / "tests"))
    from support.shared_scenes import shared_folder

    scenes = shared_folder("scenes")
    results["files"] = {}
    for name in FILES if scenes is not None else ():
        blend = next((scenes / name).rglob("*.blend"))
        output, undisturbed = machine.run(["bench.materials", str(blend), *map(str, FILES[name])])
        results["files"][name] = {**json.loads(output.splitlines()[-1]), "cpu_per_second": undisturbed}
        print(f"{name}: {json.dumps(results['files'][name])}", file=sys.stderr, flush=True)
    return results


# ------------------------------------------------------------------ shading alone


def shading(graphs: list[Graph]) -> dict[str, float]:
    """Nanoseconds per lane: the programs alone, and with one evaluation and one sample of the BSDFs."""
    compiled = compile_materials(graphs)
    points = sheet(SIDE)
    random = np.random.default_rng(0)
    material = random.integers(0, len(graphs), points.shape[1]).astype(np.int32)
    u = random.random((3, points.shape[1]), np.float32)
    work = []
    for number, batch in enumerate(compiled.batches):
        here = np.flatnonzero(compiled.batch_of[material] == number)
        lanes = ProbeLanes(material[here], np.ascontiguousarray(points[:, here]))
        work.append((batch, lanes, np.ascontiguousarray(u[:, here])))

    def programs() -> None:
        for batch, lanes, _ in work:
            batch.closures(lanes)

    def everything() -> None:
        for batch, lanes, numbers in work:
            bsdf = SliceBSDF(batch.closures(lanes), lanes)
            wo, weight = np.empty((3, lanes.n), np.float32), np.empty((3, lanes.n), np.float32)
            out = Scattered(wo, weight, np.empty(lanes.n, np.float32), np.zeros(lanes.n, np.uint8))
            bsdf.sample(numbers, out)
            bsdf.eval_pdf(wo)

    return {
        "batches": len(compiled.batches),
        "program": best(programs) / len(material) * 1e9,
        "all": best(everything) / len(material) * 1e9,
    }


def best(work: Callable[[], None]) -> float:
    """CPU seconds of the fastest of some runs."""
    work()
    seconds = []
    for _ in range(REPEATS):
        started = time.thread_time()
        work()
        seconds.append(time.thread_time() - started)
    return min(seconds)


def surface(*nodes: Node) -> Graph:
    """A material whose surface is the last node, a Principled."""
    return Graph(f"material {len(nodes)}", nodes, {"Surface": Link(len(nodes) - 1, "BSDF")})


def plain(number: int) -> Graph:
    """Principled and nothing else, with a colour and a roughness of its own."""
    r, g, b, rough = np.random.default_rng(number).uniform(0.05, 0.95, 4)
    inputs = {"Base Color": (r, g, b, 1.0), "Roughness": float(rough)}
    return surface(Node("BsdfPrincipled", "Principled", inputs))


def mixed(number: int) -> Graph:
    """One as artists leave them: metal or not, mirror-smooth or not, black or not."""
    random = np.random.default_rng(number)
    graph = plain(number)
    inputs = dict(graph.nodes[0].inputs)
    if random.random() < 0.3:
        inputs["Metallic"] = 1.0
    if random.random() < 0.2:
        inputs["Roughness"] = 0.0
    if random.random() < 0.1:
        inputs["Base Color"] = (0.0, 0.0, 0.0, 1.0)
    return replace(graph, nodes=(replace(graph.nodes[0], inputs=inputs),))


def chain(count: int) -> Graph:
    """Coordinates, then texture, ramp, mix and arithmetic in turn, one after the other, into a Principled."""
    kinds = (_noise, _ramp, _mix, _math)
    nodes = [Node("TexCoord", "coordinates", {})]
    for k in range(max(count - 2, 0)):
        nodes.append(kinds[k % len(kinds)](nodes, k))
    link = _value(nodes) if count > 1 else (0.8, 0.8, 0.8, 1.0)
    shader = Node("BsdfPrincipled", "Principled", {"Base Color": link})
    return surface(*(nodes if count > 1 else []), shader)


def _value(nodes: list[Node]) -> Link:
    socket = {"TexCoord": "Generated", "TexNoise": "Color", "ValToRGB": "Color", "Mix": "Result_Color"}
    return Link(len(nodes) - 1, socket.get(nodes[-1].kind, "Value"))


def _noise(nodes: list[Node], k: int) -> Node:
    return Node("TexNoise", f"noise {k}", {"Vector": _value(nodes), "Scale": 3.0 + k, "Detail": 2.0})


def _ramp(nodes: list[Node], k: int) -> Node:
    return Node("ValToRGB", f"ramp {k}", {"Fac": _value(nodes)})


def _mix(nodes: list[Node], k: int) -> Node:
    inputs = {"Factor_Float": 0.3, "A_Color": _value(nodes), "B_Color": (0.2, 0.5, 0.7, 1.0)}
    return Node("Mix", f"mix {k}", inputs, {"data_type": "RGBA"})


def _math(nodes: list[Node], k: int) -> Node:
    inputs = {"Value": _value(nodes), "Value_001": 1.7}
    return Node("Math", f"math {k}", inputs, {"operation": "MULTIPLY"})


# ------------------------------------------------------------------ whole files


def compared(blend: Path, width: int, height: int) -> dict[str, Any]:
    """CPU microseconds per camera sample, ours and Cycles': by rounds, and of their shortest renders."""
    import bpy

    from pt_engine.blender.export import export_scene
    from pt_engine.render import integrators  # noqa: F401  fills the registry
    from pt_engine.render.progressive import render
    from pt_engine.render.settings import RenderSettings
    from pt_engine.scene.prepare import prepare

    from .peers import CYCLES_PLAIN

    bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    frame, cycles = scene.render, scene.cycles
    frame.resolution_x, frame.resolution_y, frame.resolution_percentage = width, height, 100
    frame.use_compositing = frame.use_sequencer = False
    prepared = prepare(export_scene(bpy.context.evaluated_depsgraph_get()))
    frame.engine, frame.threads_mode, frame.threads = "CYCLES", "FIXED", 1
    bounces = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces")
    for name, value in (CYCLES_PLAIN | dict.fromkeys(bounces, DEPTH - 2)).items():
        setattr(cycles, name, value)

    def ours(samples: int) -> None:
        render(prepared, RenderSettings(width, height, samples=samples, threads=1, max_depth=DEPTH))

    def theirs(samples: int) -> None:
        cycles.samples = samples
        bpy.ops.render.render()

    def seconds(work: Callable[[int], None], samples: int) -> float:
        started = time.process_time()
        work(samples)
        return time.process_time() - started

    ours(1), theirs(1)
    rounds = [[[seconds(work, n) for n in (SHORT, LONG)] for work in (ours, theirs)] for _ in range(ROUNDS)]
    of_samples = 1e6 / ((LONG - SHORT) * width * height)
    every = np.array([*rounds, np.min(rounds, axis=0)])
    paces = (np.diff(every, axis=-1)[..., 0] * of_samples).T.tolist()  # what starts a render cancels
    return dict(zip(("ours", "cycles"), paces, strict=True)) | {"version": bpy.app.version_string}


if __name__ == "__main__":
    print(json.dumps(compared(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))))
