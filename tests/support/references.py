"""The artists' files through the command line, beside the Cycles pair that came with them.

The references were made with 12 bounces of every kind (14 edges, 12 transparent surfaces), no clamping,
160 pixels wide, filter and film from the file; `RUN` asks the engine for the same.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from support.shared_scenes import PROJECT, read_exr
from support.ztest import Agreement, compare

RUN = ("--max-depth", "14", "--set", "transparent_depth=12", "--quiet")
MAX_SECONDS = 600


@dataclass(frozen=True)
class Case:
    """One artists' file.

    `matches` says whether it must agree with Cycles within 3 % beyond noise; `cause` why it does not
    where it is further away; `samples` per pixel and seed.
    """

    name: str
    file: str
    samples: int
    matches: bool = False
    cause: str = ""


@dataclass(frozen=True)
class Outcome:
    """What came of a case."""

    agreement: Agreement
    images: tuple[np.ndarray, np.ndarray]
    statistics: dict[str, Any]

    @property
    def gaps(self) -> list[str]:
        """What was not rendered exactly, in words."""
        entries = self.statistics["coverage"]
        return sorted({f"{c['node']}: {c['effect']}" for c in entries if c["state"] != "exact"})


def outcome(case: Case, scenes: Path, samples: int | None = None) -> Outcome:
    """Render a case with two seeds and compare it with its references."""
    blend = scenes / case.name / case.file
    expected = references(scenes / case.name)
    height, width = expected[0].shape[:2]
    pair, statistics = [], {}
    for seed in (0, 1):
        image, statistics = through_engine(blend, (width, height), samples or case.samples, seed)
        pair.append(image)
    images = (pair[0], pair[1])
    return Outcome(compare(images, expected), images, statistics)


def references(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """The two Cycles images, RGBA."""
    return read_exr(folder / "reference.exr"), read_exr(folder / "reference2.exr")


def through_engine(
    blend: Path, size: tuple[int, int], samples: int, seed: int, *more: str
) -> tuple[np.ndarray, dict[str, Any]]:
    """RGBA image (top row first) and statistics of `python -m pt_engine render`."""
    with tempfile.TemporaryDirectory() as folder:
        image, stats = Path(folder) / "image.exr", Path(folder) / "stats.json"
        command = [
            *(sys.executable, "-m", "pt_engine", "render", str(blend), "-o", str(image), *RUN),
            *("--size", "{}x{}".format(*size), "--samples", str(samples), "--seed", str(seed)),
            *("--stats", str(stats), *more),
        ]
        done = subprocess.run(
            command, cwd=PROJECT, capture_output=True, text=True, timeout=MAX_SECONDS, check=False
        )
        if done.returncode:
            raise RuntimeError(f"exit code {done.returncode}: {done.stderr.strip()[-2000:]}")
        return read_exr(image), json.loads(stats.read_text(encoding="utf-8"))
