"""What the numbers were measured on, and how to hold still while measuring."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def pin(cores: int = 1) -> None:
    """Keep this process (and those it starts) on the last `cores` cores, where the system can do that."""
    if hasattr(os, "sched_setaffinity"):
        available = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, available[-cores:])


def run(arguments: list[str], cores: int = 1) -> tuple[str, float]:
    """Run a Python command pinned to `cores` cores; its output, and CPU seconds per wall second.

    The second number says how undisturbed the run was: 1.0 for a single thread that never waited.
    """
    before = os.times()
    started = time.perf_counter()
    code = f"import sys; from bench.machine import pin; pin({cores}); import runpy; {_RUN}"
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=ROOT,
        env={**os.environ, **(ONE_THREAD if cores == 1 else {})},
        capture_output=True,
        text=True,
        check=False,
    )
    wall, after = time.perf_counter() - started, os.times()
    if done.returncode:
        raise RuntimeError(f"{' '.join(arguments)} ended with {done.returncode}:\n{done.stderr[-3000:]}")
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return done.stdout, cpu / wall


_RUN = "sys.argv = sys.argv[1:]; runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)"


def description() -> dict[str, Any]:
    """Processor, system, versions and load."""
    from pt_engine.render.stats import versions

    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "load": load,
        "product_ns": product_ns(),
        "versions": versions(),
    }


def product_ns(lanes: int = 1 << 16, chain: int = 12, repeats: int = 30) -> float:
    """Nanoseconds that numpy takes per product of two float32 numbers, in arrays as a pass has them.

    A chain of products of new (3, lanes) arrays, of which several are alive at a time: what does not fit
    the second-level cache shows, as it does in a render. Tells machines apart.
    """
    import numpy as np

    def once() -> float:
        arrays = [np.full((3, lanes), 1.0 + k / 8, np.float32) for k in range(4)]
        started = time.thread_time()
        for _ in range(chain):
            arrays = [*arrays[1:], arrays[0] * arrays[2]]
        return time.thread_time() - started

    return min(once() for _ in range(repeats)) / (chain * 3 * lanes) * 1e9


def processor() -> str:
    """Its name, as far as the system tells."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
