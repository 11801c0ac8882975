"""Are the errors that a render tells true? `python -m bench.calibration` writes docs/calibration.md.

`python -m bench.calibration coverage` (or z, bias, predictions, targets, adaptive) measures that part of it
alone, and `page` writes it from what has been measured so far.

Six small scenes, many seeds; the truth is the mean of all the other seeds' renders. Each part's result lies
in out/bench/calibration and is not measured again while it is there. Nothing is measured in seconds, so
other programs on the machine do not matter.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from pt_engine.render import forecast
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
SIZE, SAMPLES, SEEDS, FEW, DEPTH = 32, 64, 100, 16, 4
MORE, MORE_SEEDS = 1 << 10, 24  # samples with which z is asked again
STEADY = 4.0  # times their mean or a part of it: within are all seeds' stated variances of a steady pixel
ROUNDING = 1e-6  # of a pixel: the standard error of one that sees the sky alone is but float32's
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
SHORT = {
    "uniform": {"samples": 8},
    "target error": {"samples": 64, "target_error": 0.25, "min_samples": 4},
    "pixels": {"samples": 64, "target_error": 0.4, "target_percentile": 90.0, "min_samples": 4},
    "adaptive": {"samples": 64, "adaptive": True, "min_samples": 4},
}  # fmt: skip
FORETOLD_SIZE, FORETOLD_SEEDS = 128, 8
SHORT_SCENE, SHORT_SIZE, SHORT_SEEDS = "rough glass, shining square", 8, 2000
LONG, LONG_SEEDS = 1 << 13, 64  # samples, four times as many as those of the short renders together


@cache
def prepared(name: str) -> Scene:
    """One of the scenes."""
    return prepare(SNAPSHOTS[name]())


def rendered(name: str, size: int = SIZE, **how: Any) -> RenderResult:
    """A render of it, on one thread."""
    return render(prepared(name), RenderSettings(size, size, threads=1, max_depth=DEPTH, **how))


def picture(result: RenderResult) -> np.ndarray:
    """(height, width, 3) float64."""
    return result.image()[..., :3].astype(np.float64)


def seeds(name: str, sampler: str) -> dict[str, np.ndarray]:
    """What every seed's render is and says: images, standard errors, errors with their intervals."""
    path = FOLDER / f"{name}, {sampler}.npz"
    if not path.exists():
        rows: dict[str, list[Any]] = {"image": [], "standard_error": [], "stated": [], "fireflies": []}
        for seed in range(SEEDS):
            result = rendered(name, samples=SAMPLES, seed=seed, sampler=sampler)
            error = result.film.error()
            rows["image"].append(picture(result))
            rows["standard_error"].append(result.film.standard_error())
            rows["stated"].append([(error[k], *error[f"{k}_ci95"]) for k in ("mse", "relmse")])
            rows["fireflies"].append(error["fireflies"])
        FOLDER.mkdir(parents=True, exist_ok=True)
        np.savez(path, **{k: np.array(v) for k, v in rows.items()})
    with np.load(path) as found:
        return dict(found)


def truth(name: str) -> np.ndarray:
    """The mean of all that was rendered for `coverage` with Sobol points."""
    mean: np.ndarray = seeds(name, SAMPLERS[0])["image"].mean(axis=0)
    return mean


def errors(image: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """True MSE and relMSE."""
    squared = (image - reference) ** 2
    floor = 0.01 * reference.mean() ** 2
    return float(squared.mean()), float((squared / (reference**2 + floor)).mean())


def coverage(name: str, sampler: str) -> dict[str, Any]:
    """Intervals that hold the truth, and each pixel's z."""
    found = seeds(name, sampler)
    images, stated = found["image"], found["stated"]
    # the mean of n − 1 others is off by 1/(n − 1) of the variance itself
    others = (images.sum(axis=0) - images) / (SEEDS - 1)
    shrink = np.sqrt((SEEDS - 1) / SEEDS)
    true = np.array([errors(o + shrink * (image - o), o) for image, o in zip(images, others, strict=True)])
    inside = (stated[..., 1] <= true) & (true <= stated[..., 2])
    return {
        "inside": inside.mean(axis=0).tolist(),
        "fireflies": float(np.median(found["fireflies"])),
        "ratio": (stated[..., 0].mean(axis=0) / true.mean(axis=0)).tolist(),
        "relative": float(np.sqrt(true[:, 1].mean())),
        **z_scores(images, found["standard_error"]),
    }


def z_scores(images: np.ndarray, standard_error: np.ndarray) -> dict[str, Any]:
    """How many pixels are steady over all seeds, and the spread of their errors over the stated ones."""
    number = len(images)
    # from the mean of the others, whose own error is 1/(number − 1) of the variance
    off = (images - images.mean(axis=0)) * np.sqrt(number / (number - 1))
    variance = standard_error.astype(np.float64) ** 2
    mean = variance.mean(axis=0)
    steady = (variance.max(axis=0) < STEADY * mean) & (variance.min(axis=0) > mean / STEADY)
    steady &= mean > (ROUNDING * images.mean(axis=0)) ** 2
    z = off[:, steady] / np.sqrt(variance[:, steady])
    return {"steady": float(steady.mean()), "z": float(z.std()) if steady.any() else None}


def z_of_more(name: str, sampler: str) -> dict[str, Any]:
    """The same of renders with many samples."""
    how = {"samples": MORE, "sampler": sampler}
    films = [rendered(name, seed=4000 + k, **how) for k in range(MORE_SEEDS)]
    images, stated = zip(*((picture(r), r.film.standard_error()) for r in films), strict=True)
    return z_scores(np.array(images), np.array(stated))


def targets(name: str) -> dict[str, Any]:
    """Renders that stop at the error of 64 samples: where they land, and what they say."""
    reference, target = truth(name), error_of_64(name)
    landed, told = [], []
    for seed in range(1000, 1000 + FEW):
        result = rendered(name, samples=16 * SAMPLES, seed=seed, target_error=target)
        landed.append(errors(picture(result), reference)[1])
        told.append(result.error()["relmse"])
    return {
        "target": target,
        "landed": float(np.sqrt(np.mean(landed)) / target),
        "told": float(np.sqrt(np.mean(told)) / target),
    }


def error_of_64(name: str, sampler: str = SAMPLERS[0]) -> float:
    """True relative error of `SAMPLES` samples."""
    reference = truth(name)
    return float(np.sqrt(np.mean([errors(im, reference)[1] for im in seeds(name, sampler)["image"]])))


def predictions(name: str, sampler: str, size: int = FORETOLD_SIZE) -> dict[str, Any]:
    """What a larger picture foretells a tenth into the way to half that error, over what it took.

    `limit` is how many would be within 20 % with the best factor for this row: more is not to be had by one.
    """
    forecast.ALLOWANCE = np.inf  # on a busy machine it would look later than at a tenth
    foretold, held, made = [], [], []
    how = {"samples": 16 * SAMPLES, "target_error": error_of_64(name, sampler) / 2}
    for seed in range(2000, 2000 + FORETOLD_SEEDS):
        result = rendered(name, size, seed=seed, sampler=sampler, **how)
        taken = result.progress.camera_samples / size**2
        if (early := result.progress.forecast.early(taken)) is not None:
            foretold.append(early.samples / taken)
            made.append(early.from_samples / taken)
            held.append(early.samples_ci95[0] <= taken <= early.samples_ci95[1])
    within, *others = (within_20_percent(foretold, by) for by in (1.0, *np.linspace(0.3, 3.0, 271)))
    return {
        "number": len(foretold),
        "made": float(np.median(made)),
        "within": within,
        "limit": max(within, *others),
        "foretold": [float(x) for x in np.quantile(foretold, (0.05, 0.5, 0.95))],
        "held": float(np.mean(held)),
    }


def within_20_percent(foretold: list[float], by: float) -> float:
    """The share of what was foretold over what it took that is right if divided by a factor."""
    return float(np.mean(np.abs(np.array(foretold) / by - 1) < 0.2))


def adaptive(name: str) -> dict[str, Any]:
    """Efficiency 1 / (error × samples) of adaptive against uniform sampling."""
    reference = truth(name)
    uniform, chosen = [], []
    for seed in range(3000, 3000 + FEW):
        result = rendered(name, samples=2 * SAMPLES, adaptive=True, seed=seed)
        spent = result.progress.camera_samples / SIZE**2
        chosen.append((*errors(picture(result), reference), spent))
        same = rendered(name, samples=round(spent), seed=seed)
        uniform.append((*errors(picture(same), reference), round(spent)))
    ours, theirs = np.mean(chosen, axis=0), np.mean(uniform, axis=0)
    gain = [theirs[k] * theirs[2] / (ours[k] * ours[2]) for k in range(2)]
    return {"samples": float(ours[2]), "gain": gain}


def in_parts(images: np.ndarray) -> np.ndarray:
    """(n, 16) means of the parts of n small images."""
    sixteen: np.ndarray = images.reshape(-1, 4, 2, 4, 2, 3).mean(axis=(2, 4, 5)).reshape(len(images), -1)
    return sixteen


def mean_and_error(values: np.ndarray) -> np.ndarray:
    """(2, ...) the mean over the first axis, and its standard error."""
    return np.stack([values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))])


@cache
def converged() -> np.ndarray:
    """Many long renders' parts: (n, 16)."""
    long = (rendered(SHORT_SCENE, SHORT_SIZE, samples=LONG, seed=10**6 + k) for k in range(LONG_SEEDS))
    return in_parts(np.array([picture(result) for result in long]))


def bias(kind: str) -> dict[str, Any]:
    """Mean of many short renders against long ones: its z, of the whole and the worst of 16 parts."""
    short = (rendered(SHORT_SCENE, SHORT_SIZE, seed=k, **SHORT[kind]) for k in range(SHORT_SEEDS))
    found = in_parts(np.array([picture(result) for result in short]))
    here, there = mean_and_error(found), mean_and_error(converged())
    z = (here[0] - there[0]) / np.hypot(here[1], there[1])
    here, there = mean_and_error(found.mean(axis=1)), mean_and_error(converged().mean(axis=1))
    difference, error = float(here[0] - there[0]), float(np.hypot(here[1], there[1]))
    return {
        "difference": difference / float(there[0]),
        "uncertainty": error / float(there[0]),
        "z": difference / error,
        "worst": float(np.abs(z).max()),
    }


def parts() -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """Name and measurement of each part, the most telling first."""
    for sampler in SAMPLERS:
        for name in SNAPSHOTS:
            yield f"coverage, {name}, {sampler}", lambda n=name, s=sampler: coverage(n, s)
            yield f"z, {name}, {sampler}", lambda n=name, s=sampler: z_of_more(n, s)
            yield f"predictions, {name}, {sampler}", lambda n=name, s=sampler: predictions(n, s)
        if sampler == SAMPLERS[0]:
            for kind in SHORT:
                yield f"bias, {kind}", lambda k=kind: bias(k)
            for part, measure in (("targets", targets), ("adaptive", adaptive)):
                for name in SNAPSHOTS:
                    yield f"{part}, {name}", lambda m=measure, n=name: m(n)


def results(wanted: str) -> dict[str, dict[str, Any]]:
    """What there is of every part; what is missing of those that start with `wanted` is measured now."""
    found = {}
    FOLDER.mkdir(parents=True, exist_ok=True)
    for key, measure in parts():
        path = FOLDER / f"{key}.json"
        if key.startswith(wanted) and not path.exists():
            started = time.process_time()
            result = measure()
            result["cpu_seconds"] = time.process_time() - started
            path.write_text(json.dumps(result), encoding="utf-8")
            sys.stderr.write(f"{key}: {result}\n")
        if path.exists():
            found[key] = json.loads(path.read_text(encoding="utf-8"))
    return found


def main(what: str = "") -> None:
    """Measure what is missing of `what` (nothing for `page`) and write the page."""
    from .calibration_page import page

    (machine.ROOT / "docs" / "calibration.md").write_text(page(results(what)), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
