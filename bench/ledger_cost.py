"""What keeping the ledger costs a render, from many short renders with it and without, in turns.

A unit of work as renders have it is rendered without a clock, with one that only counts, and with one that
also tells the stages apart; then thrice more in the reverse order, so that a drift of the machine's pace
falls out; and so in each order of the three. What is averaged is the logarithm of the ratio of CPU times of
the same unit; a fifth at either end is left out, where another program has had the caches (a trimmed mean,
with the standard error of Tukey and McLaughlin 1963).
"""

from __future__ import annotations

import itertools
import time
from contextlib import nullcontext

import numpy as np
from numpy.typing import NDArray

from pt_engine.core.clock import Clock, runs
from pt_engine.core.memory import kept_buffers
from pt_engine.render.ledger import TIMED_PART
from pt_engine.render.schedule import Unit
from pt_engine.render.worker import Worker

SECONDS, FEWEST = 60.0, 30
TRIMMED = 0.2
Cost = tuple[float, float]


def ledger_costs(worker: Worker, units: list[Unit], seconds: float = SECONDS) -> dict[str, Cost]:
    """Part of the CPU time and its standard error: as renders keep it, and if they looked everywhere."""
    until = time.perf_counter() + seconds
    turns = ((unit, order) for unit in itertools.cycle(units) for order in itertools.permutations(range(3)))
    clocks = (None, Clock(part=0.0), Clock(part=1.0))  # what a clock meets first it looks into, but once
    with kept_buffers():
        for clock in clocks:
            cpu_seconds(worker, units[0], clock)
        logs = []
        while len(logs) < FEWEST or time.perf_counter() < until:
            (unit, order), spent = next(turns), [0.0, 0.0, 0.0]
            for kind in (*order, *reversed(order)):
                spent[kind] += cpu_seconds(worker, unit, clocks[kind])
            logs.append(np.log(spent[1:]) - np.log(spent[0]))
    counted, looked_into = np.array(logs).T
    return {
        "cost": trimmed_mean((1 - TIMED_PART) * counted + TIMED_PART * looked_into),
        "looked_into": trimmed_mean(looked_into),
    }


def cpu_seconds(worker: Worker, unit: Unit, clock: Clock | None) -> float:
    """Of one render of a unit."""
    started = time.thread_time()
    with runs(clock) if clock else nullcontext():
        worker.render(unit)
    return time.thread_time() - started


def trimmed_mean(values: NDArray[np.float64]) -> Cost:
    """The mean of the middle, and its standard error."""
    ordered = np.sort(values)
    cut = int(TRIMMED * len(ordered))
    kept = ordered[cut : len(ordered) - cut]
    winsorized = np.clip(ordered, kept[0], kept[-1])
    error = np.std(winsorized, ddof=1) / ((1 - 2 * TRIMMED) * np.sqrt(len(ordered)))
    return float(np.mean(kept)), float(error)
