"""Whole renders: through the command line, by the peers, and by Embree alone; one core each."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from . import machine
from .shapes import FRAMES, RR_DEPTH

TARGETS = {"S1": 1.6e6, "S2": 1.5e6, "S4": 1.0e6}  # camera samples per second on one core
SECONDS = 4.0  # of rendering per measurement
REPEATS = 2


def renders(blends: dict[str, Path], peers: bool = True) -> dict[str, Any]:
    """All figures of each scene."""
    results = {}
    for name, blend in blends.items():
        results[name] = measure(blend, peers)
        print(f"{name}: {json.dumps(results[name])}", file=sys.stderr, flush=True)
    return results


def measure(blend: Path, peers: bool) -> dict[str, Any]:
    """One scene: the engine's paces, Embree's, and the peers'."""
    output, _ = machine.run(["bench.stages", str(blend)])
    own = json.loads(output.splitlines()[-1])
    result: dict[str, Any] = {
        "target": TARGETS[blend.stem],
        "independent": best(blend, "independent", 1),
        "sobol": best(blend, "sobol", 1),
        "embree_only_samples_per_cpu_second": own["embree_only_samples_per_cpu_second"],
        "embree_share": own["embree_share"],
        "in_process_samples_per_cpu_second": own["samples_per_cpu_second"],
    }
    one, two = result["sobol"], best(blend, "sobol", 2)
    result["two_threads"] = two
    result["two_threads_gain"] = two["samples_per_second"] / one["samples_per_second"]
    result["sobol_cost"] = result["independent"]["samples_per_second"] / one["samples_per_second"] - 1
    if peers:
        for peer in ("mitsuba", "cycles"):
            output, undisturbed = machine.run(["bench.peers", peer, str(blend)])
            result[peer] = {**json.loads(output.splitlines()[-1]), "cpu_per_second": undisturbed}
    return result


def best(blend: Path, sampler: str, threads: int) -> dict[str, float]:
    """The faster of some renders through `python -m pt_engine render`."""
    tries = [through_command_line(blend, sampler, threads) for _ in range(REPEATS)]
    return max(tries, key=lambda found: found["samples_per_second"])


def through_command_line(blend: Path, sampler: str, threads: int) -> dict[str, float]:
    """Camera samples per second of the render phase, as stats.json says."""
    frame = FRAMES[blend.stem]
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        arguments = [
            *("pt_engine", "render", str(blend), "-o", str(Path(folder) / "image.exr")),
            *("--threads", str(threads), "--samples", "0", "--seconds", str(SECONDS)),
            *("--max-depth", str(frame.max_depth), "--stats", str(stats)),
            *("--set", f"rr_depth={RR_DEPTH}", "--set", f"sampler={sampler}"),
        ]
        _, undisturbed = machine.run(arguments, cores=threads)
        found = json.loads(stats.read_text(encoding="utf-8"))
    return {
        "samples_per_second": found["camera_samples_per_second"],
        "rays_per_second": found["rays_per_second"],
        "cpu_per_second": undisturbed,
    }
