"""Are the errors that a render tells true? `python -m bench.calibration` writes docs/calibration.md.

Six small scenes, many seeds, against converged references. Each part's result lies in out/bench/calibration as
JSON and is not measured again while it is there.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pt_engine.render.progressive import RenderResult, render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.scene import Scene
from pt_engine.scene.snapshot import LightData

from . import machine

sys.path.insert(0, str(machine.ROOT / "tests"))

from support import rooms
from support import scenes as make

FOLDER = machine.ROOT / "out" / "bench" / "calibration"
SIZE, SAMPLES, SEEDS = 24, 64, 100
STEADY = 0.5  # largest relative spread of a pixel's stated variance over the seeds: its samples are not few
SAMPLERS = ("sobol", "independent")
SKY = make.world((0.3, 0.4, 0.6))
BULB = LightData("POINT", "bulb", make.translation(0.8, -1.0, 2.2), 90.0, radius=0.2)
SUN = LightData("SUN", "sun", make.looking((1.0, -1.5, 3.0), (0, 0, 0)), 3.0, angle=0.2)
SNAPSHOTS = {
    "matte, area lamp": lambda: rooms.room(make.diffuse(0.5), rooms.SOFT_LAMP),
    "rough metal, area lamp, sky": lambda: rooms.room(rooms.ROUGH, rooms.SOFT_LAMP, SKY),
    "rough glass, shining square": lambda: rooms.room(rooms.GLASS),
    "veil, area lamp, sky": lambda: rooms.room(rooms.half_transparent(0.5), rooms.SOFT_LAMP, SKY),
    "mirror, sun, sky": lambda: rooms.room(rooms.MIRROR, SUN, SKY),
    "matte, bulb": lambda: rooms.room(make.diffuse(0.8), BULB),
}


class Place:
    """A scene, its reference and what is known of it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.scene: Scene = prepare(SNAPSHOTS[name]())
        self.reference = self.image(self.render(samples=4096, seed=10**6))
        self.floor = 0.01 * self.reference.mean() ** 2

    def render(self, **how: Any) -> RenderResult:
        """A render of it, on one thread."""
        return render(self.scene, RenderSettings(SIZE, SIZE, threads=1, **how))

    @staticmethod
    def image(result: RenderResult) -> np.ndarray:
        """(height, width, 3) float64."""
        return result.image()[..., :3].astype(np.float64)

    def errors(self, image: np.ndarray) -> tuple[float, float]:
        """True MSE and relMSE."""
        squared = (image - self.reference) ** 2
        return float(squared.mean()), float((squared / (self.reference**2 + self.floor)).mean())


def coverage(place: Place, sampler: str) -> dict[str, Any]:
    """Intervals that hold the truth, and each pixel's z."""
    inside, stated, true, spread, z = [], [], [], [], []
    for seed in range(SEEDS):
        result = place.render(samples=SAMPLES, seed=seed, sampler=sampler)
        error, image = result.film.error(), place.image(result)
        pair = place.errors(image)
        inside.append(
            [low <= e <= high for (low, high), e in zip(_intervals(error), pair, strict=True)]
        )
        stated.append([error["mse"], error["relmse"]])
        true.append(pair)
        standard_error = result.film.standard_error().astype(np.float64)
        spread.append(standard_error**2)
        with np.errstate(divide="ignore", invalid="ignore"):
            z.append((image - place.reference) / standard_error)
    variance = np.array(spread)
    steady = variance.std(axis=0) < STEADY * variance.mean(axis=0)
    scores = np.array(z)[:, steady]
    return {
        "inside": np.mean(inside, axis=0).tolist(),
        "stated": np.mean(stated, axis=0).tolist(),
        "true": np.mean(true, axis=0).tolist(),
        "steady": float(steady.mean()),
        "z": float(scores[np.isfinite(scores)].std()) if steady.any() else None,
    }


def _intervals(error: Any) -> list[tuple[float, float]]:
    return [error["mse_ci95"], error["relmse_ci95"]]


def targets(place: Place, sampler: str) -> dict[str, Any]:
    """Renders that stop at an error: where they land, what they say of themselves, what they foretold."""
    target = float(np.sqrt(np.mean([place.errors(_mean_of(place, sampler, k))[1] for k in range(20)])))
    landed, told, foretold = [], [], []
    for seed in range(1000, 1000 + SEEDS // 4):
        result = place.render(samples=16 * SAMPLES, seed=seed, sampler=sampler, target_error=target)
        landed.append(place.errors(place.image(result))[1])
        told.append(result.error()["relmse"])
        early = result.progress.forecast.early
        if early is not None:
            foretold.append(early.samples / result.progress.samples)
    return {
        "target": target,
        "landed": float(np.sqrt(np.mean(landed)) / target),
        "told": float(np.sqrt(np.mean(told)) / target),
        "within": float(np.mean(np.abs(np.array(foretold) - 1) < 0.2)) if foretold else None,
        "foretold": [float(x) for x in np.quantile(foretold, (0.05, 0.5, 0.95))] if foretold else None,
    }


def _mean_of(place: Place, sampler: str, seed: int) -> np.ndarray:
    return place.image(place.render(samples=SAMPLES, seed=2000 + seed, sampler=sampler))


def adaptive(place: Place, sampler: str) -> dict[str, Any]:
    """Efficiency 1 / (error × samples) of adaptive against uniform sampling."""
    uniform, chosen = [], []
    for seed in range(3000, 3000 + SEEDS // 4):
        how = {"seed": seed, "sampler": sampler}
        result = place.render(samples=2 * SAMPLES, adaptive=True, **how)
        spent = result.progress.camera_samples / SIZE**2
        chosen.append((*place.errors(place.image(result)), spent))
        same = place.render(samples=round(spent), **how)
        uniform.append((*place.errors(place.image(same)), round(spent)))
    ours, theirs = np.mean(chosen, axis=0), np.mean(uniform, axis=0)
    return {
        "samples": ours[2],
        "gain": [theirs[k] * theirs[2] / (ours[k] * ours[2]) for k in range(2)],
    }


SHORT = {
    "uniform": {"samples": 8},
    "target error": {"samples": 64, "target_error": 0.25, "min_samples": 4},
    "target of pixels": {"samples": 64, "target_error": 0.4, "target_percentile": 90.0, "min_samples": 4},
    "adaptive": {"samples": 64, "adaptive": True, "min_samples": 4},
}
SHORT_SIZE, SHORT_SEEDS = 8, 1000


def bias(place: Place, kind: str) -> dict[str, Any]:
    """Mean of 1,000 short renders against many samples: its z, of the whole and the worst of 16 parts."""
    frame = {"width": SHORT_SIZE, "height": SHORT_SIZE, "threads": 1}
    truth = render(place.scene, RenderSettings(**frame, samples=1 << 16, seed=10**6)).image()[..., :3]
    images = np.array(
        [
            render(place.scene, RenderSettings(**frame, seed=seed, **SHORT[kind])).image()[..., :3]
            for seed in range(SHORT_SEEDS)
        ],
        np.float64,
    )
    whole = images.mean(axis=(1, 2, 3))
    parts = images.reshape(SHORT_SEEDS, 4, 2, 4, 2, 3).mean(axis=(2, 4, 5)).reshape(SHORT_SEEDS, -1)
    expected = truth.astype(np.float64).reshape(4, 2, 4, 2, 3).mean(axis=(1, 3, 4)).reshape(-1)
    z = (parts.mean(axis=0) - expected) / (parts.std(axis=0, ddof=1) / np.sqrt(SHORT_SEEDS))
    error = whole.std(ddof=1) / np.sqrt(SHORT_SEEDS)
    return {
        "difference": float((whole.mean() - expected.mean()) / expected.mean()),
        "uncertainty": float(error / expected.mean()),
        "z": float((whole.mean() - expected.mean()) / error),
        "worst": float(np.abs(z).max()),
    }


def kept(name: str, measure: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """The part's result, from its file or measured now."""
    path = FOLDER / f"{name}.json"
    if not path.exists():
        started = time.process_time()
        result = measure()
        result["cpu_seconds"] = time.process_time() - started
        FOLDER.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(result), encoding="utf-8")
        sys.stderr.write(f"{name}: {result}\n")
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


PARTS = {"coverage": coverage, "targets": targets, "adaptive": adaptive}
SHORT_PLACES = ("rough glass, shining square",)


def main(chosen: list[str]) -> None:
    """Measure what is not there yet, and write the page."""
    results: dict[str, Any] = {}
    places: dict[str, Place] = {}

    def place(name: str) -> Place:
        if name not in places:
            places[name] = Place(name)
        return places[name]

    for part, measure in PARTS.items():
        for name in SNAPSHOTS if not chosen or part in chosen else ():
            for sampler in SAMPLERS if part == "coverage" else SAMPLERS[:1]:
                key = f"{part}, {name}, {sampler}"
                results[key] = kept(key, lambda m=measure, n=name, s=sampler: m(place(n), s))
    for name in SHORT_PLACES if not chosen or "bias" in chosen else ():
        for kind in SHORT:
            key = f"bias, {name}, {kind}"
            results[key] = kept(key, lambda n=name, k=kind: bias(place(n), k))
    if not chosen:
        from .calibration_page import page

        Path(machine.ROOT / "docs" / "calibration.md").write_text(page(results), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
