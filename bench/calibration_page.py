"""docs/calibration.md from what `bench.calibration` has measured."""

from __future__ import annotations

from typing import Any

from .calibration import DEPTH, FEW, SAMPLES, SEEDS, SHORT_SCENE, SHORT_SEEDS, SHORT_SIZE, SIZE, STEADY

Results = dict[str, dict[str, Any]]

HEAD = f"""# Are the errors true that a render tells?

Made by `python -m bench.calibration` (half a minute of one core for each row of the first table; it
goes on where it was stopped). Six scenes of {SIZE} × {SIZE} pixels, {SAMPLES} samples, paths of {DEPTH}
edges, {SEEDS} seeds; the truth is the mean of the other seeds' renders. A part that is not in a table
is not measured yet.

## The image's error

How many of {SEEDS} 95 % intervals hold the squared error of their own image; the mean of the stated error
over the mean of the true one; the relative error itself. *Steady* pixels are those whose stated variance
differs from seed to seed by less than {STEADY:.0%} of its mean; z is the spread of (pixel − truth) /
standard error over these.

| scene, sampler | MSE inside | relMSE inside | MSE stated/true | relMSE stated/true | √relMSE | steady | z |
|---|---|---|---|---|---|---|---|"""

NOTES = """
Where it breaks: a pixel that has not met its rare bright samples yet knows nothing of them, and its standard
error is too small until it does. In glass lit by a small square that is most pixels at this number of
samples: the image's MSE is right, since bright pixels carry it, but relMSE, where dark pixels count as much,
is told too low, and its interval misses. z is too large there even where the stated variance is steady: the
gain of Sobol points is averaged over 7 × 7 pixels, which mixes clean edges with sparkling surfaces.
"""

TARGET = f"""
## Stopping at an error

{FEW} renders to the relative error that {SAMPLES} Sobol samples have: the true error over the target;
what the half of the pixels tells that had no say; how many predictions made at a tenth were within 20 %
of the samples it took, and the 5th, 50th and 95th percentile of foretold / taken.

| scene | target | landed | told | within 20 % | foretold / taken |
|---|---|---|---|---|---|"""

BIAS = f"""
## Bias

{SHORT_SEEDS} short renders of "{SHORT_SCENE}", {SHORT_SIZE} × {SHORT_SIZE} pixels, against 32,768
samples: relative difference of the means, its standard error, z, and the largest |z| of 16 parts of the
image (3.0 is exceeded by chance in 4 % of such tables).

| stops by | difference | standard error | z | worst part |
|---|---|---|---|---|"""

ADAPTIVE = f"""
## Adaptive sampling

Efficiency 1 / (error × samples) against uniform sampling with as many samples, {FEW} seeds, at most
{2 * SAMPLES} samples a pixel; above 1 adaptive sampling wins. It is off by default.

| scene | samples | gain in MSE | gain in relMSE |
|---|---|---|---|"""


def page(results: Results) -> str:
    """The whole page."""
    lines = [HEAD]
    for key, r in of(results, "coverage"):
        z = "–" if r["z"] is None else f"{r['z']:.2f}"
        lines.append(
            f"| {key} | {r['inside'][0]:.0%} | {r['inside'][1]:.0%} | {r['ratio'][0]:.2f} | "
            f"{r['ratio'][1]:.2f} | {r['relative']:.1%} | {r['steady']:.0%} | {z} |"
        )
    lines += [NOTES, TARGET] if of(results, "targets") else [NOTES]
    for key, r in of(results, "targets"):
        within, spread = "–", "–"
        if r["within"] is not None:
            within, spread = f"{r['within']:.0%}", ", ".join(f"{x:.2f}" for x in r["foretold"])
        row = f"| {key} | {r['target']:.3f} | {r['landed']:.2f} | {r['told']:.2f} | {within} | {spread} |"
        lines.append(row)
    lines += [BIAS] if of(results, "bias") else []
    for key, r in of(results, "bias"):
        lines.append(
            f"| {key} | {r['difference']:+.2%} | {r['uncertainty']:.2%} | {r['z']:+.1f} | {r['worst']:.1f} |"
        )
    lines += [ADAPTIVE] if of(results, "adaptive") else []
    for key, r in of(results, "adaptive"):
        lines.append(f"| {key} | {r['samples']:.0f} | {r['gain'][0]:.2f} | {r['gain'][1]:.2f} |")
    return "\n".join(lines) + "\n"


def of(results: Results, part: str) -> list[tuple[str, dict[str, Any]]]:
    """The results of one part, by the rest of their names."""
    start = f"{part}, "
    return [(key.removeprefix(start), r) for key, r in results.items() if key.startswith(start)]
