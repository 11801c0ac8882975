"""docs/calibration.md from what `bench.calibration` has measured."""

from __future__ import annotations

from statistics import mean
from typing import Any

from .calibration import (
    DEPTH,
    FEW,
    FORETOLD_SEEDS,
    FORETOLD_SIZE,
    LONG,
    LONG_SEEDS,
    MORE,
    MORE_SEEDS,
    SAMPLES,
    SEEDS,
    SHORT_SCENE,
    SHORT_SEEDS,
    SHORT_SIZE,
    SIZE,
    STEADY,
)

Results = dict[str, dict[str, Any]]

HEAD = f"""# Are the errors true that a render tells?

Made by `python -m bench.calibration` (half an hour of one core; it goes on where it was stopped, and
nothing in it is measured in seconds). Six scenes of {SIZE} × {SIZE} pixels, {SAMPLES} samples, paths of
{DEPTH} edges, {SEEDS} seeds; the truth is the mean of the other seeds' renders.

## The image's error

How many of {SEEDS} 95 % intervals hold the squared error of their own image (of so many true 95 % intervals,
91 to 99 do by chance; of all rows together 94 to 96 %); the mean of the stated error over the mean of the
true one; the relative error itself; the factor *fireflies* (docs/stats.md). *Steady* pixels are those whose
stated variance is within a factor of {STEADY:g} of its mean in every seed, and more than float32's rounding
(a pixel that sees an even sky alone has no noise); z is the spread of (pixel − truth) / standard error over
these.

| scene, sampler | MSE | relMSE | MSE told/true | relMSE told/true | √relMSE | fireflies | steady | z |
|---|---|---|---|---|---|---|---|---|"""

NOTES = """
Where it breaks:

- *Fireflies.* A pixel that has not met its rare bright samples yet knows nothing of them, and its standard
  error is too small until it does: such pixels are not steady. For the image this evens out, since bright
  pixels carry the error of those that were lucky. But relMSE divides by the square of the radiance, and
  whether a bright sample in a dark pixel is light or noise, the samples cannot tell; its interval then spans
  both answers, the factor is told as `fireflies`, and from 1.5 on the command line, the panel and the page
  say so.
- *Skewed noise.* A pixel that was lucky with bright samples is bright and says that it is noisy, both at
  once, so that v / R² comes out too small: 3 % on the matte rows.
- *Long tails.* The interval's width comes from the squares of the stated variances, which long tails make
  larger, and takes channels as fully correlated: relMSE's is too wide on metal, mirror and
  glass.
- *Outlines, with Sobol points.* On the edge of a wall before an even sky stratification gains more than on
  noisy surfaces beside it, and the pixel is told what it gained around: its error is smaller than stated. In
  the two columns of the wall's edges z is 0.55 with rough metal in the room; that is a quarter of its steady
  pixels, and z of the others is 1.01.
- *Other scenes.* Five rooms that are in no table (24 samples, 60 seeds, both samplers): MSE 95.5 %, rows
  from 90 to 100 %; relMSE 97.3 %, rows from 92 to 100 %. The lowest are rooms that a shining square lights,
  with a factor of 3 and 10 for fireflies.
- *Few independent values.* z is the wider for it: a standard error from 49 differences makes z a Student's t,
  whose spread is 1.02 to 1.05, and long tails make it more. The variances are right: over steady pixels with
  independent samples, the mean squared error is 0.99 to 1.03 of the mean stated one in all six scenes.
- *Motion blur.* Pixels that see the same thing move see it at the same moments, so their errors are not
  independent, and the interval is too narrow, though the error itself is not: of 60 renders of a ball that
  flies by, 16 × 16 pixels, 16 samples, it held 93 % with Sobol points and 85 % with independent ones; where
  so much moves that a moment serves four samples, 33 and 42 %.
"""

MORE_SAMPLES = f"""
## z with more samples

The same scenes, {MORE_SEEDS} seeds of {MORE:,} samples: a pixel's variance is less uncertain, and z is nearer
to 1, but with Sobol points on rough metal and the mirror, where few pixels are steady and many are outlines.
In the two columns of the wall's edges z is 0.56 and 0.88, elsewhere 0.92 and 0.97: what stratification
gains differs from pixel to pixel there, too. The standard error is too large, not too small.

| scene, sampler | steady | z |
|---|---|---|"""

TARGET = f"""
## Stopping at an error

{FEW} renders to the relative error that {SAMPLES} Sobol samples have: the true error over the target, and
the told one over it.

| scene | target | landed | told |
|---|---|---|---|"""

FORETOLD = f"""
## Predictions

{FORETOLD_SEEDS} renders of {FORETOLD_SIZE} × {FORETOLD_SIZE} pixels to half the error of {SAMPLES} samples:
how far the render was when the first prediction from a tenth on was *made* (the film is looked at now and
then); how many of these were within 20 % of the samples it took; how many would be with the best factor for
that row, the *limit* that scatter from seed to seed sets to mending them by one; the 5th, 50th and 95th
percentile of foretold / taken; and how many of the 95 % intervals held what it took.

Where no sample is rare, all are within 20 %. With fireflies n E² that is told falls as rare samples are told
from light: on rough glass it is 2 to 3 times too large at a tenth. The 3 × 3 pixels around each foretell that
fall (`render/film_windows.py`) to 15 % in the median of these scenes. The rest is scatter: rare samples carry
the variance, too, and a tenth of the render has met few of them. Of four renders each, at 16 and 24 samples,
n E² with every pixel's true radiance in place of its level scattered by 12 to 15 % on the mirror with Sobol
points, 24 to 30 % with independent ones, and 12 to 34 % on rough glass: knowing the levels narrows little.

With eight other seeds 72 % were within 20 % on rough glass and the mirror, and 56 % where 3 × 3 pixels were
taken as one. Nor do all scenes do as well. In four rooms that are in no table (a ball of rough glass under a
sun and a sky, of rough metal beside a bulb, and of rough metal and a mirror below the shining square; 3 seeds
of 256 samples, both samplers) 69 % were within 20 %, and 74 % where 3 × 3 pixels were taken as one. Below the
square, with independent samples, a fifth too few are foretold: at 16 samples n E² is told a tenth too small
there, and the fall that is foretold does not come.

| scene, sampler | made | within 20 % | limit | foretold / taken | interval holds |
|---|---|---|---|---|---|"""

BIAS = f"""
## Bias

{SHORT_SEEDS} short renders of "{SHORT_SCENE}", {SHORT_SIZE} × {SHORT_SIZE} pixels, against {LONG_SEEDS} of
{LONG:,} samples: relative difference of the means, its standard error (of both), z, and the largest |z| of 16
parts of the image (3.0 is exceeded by chance in 4 % of such tables). Adaptive sampling is unbiased by
construction: no pixel's number of samples follows from its own samples, by no way round
(`render/adaptive.py`). With a target error each quarter of the pixels ends when the others are good enough
(`render/decisions.py`). A limit of time is kept by the clock, which numbers of samples cannot test: it is
biased as far as bright paths take longer.

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
            f"{r['ratio'][1]:.2f} | {r['relative']:.1%} | {r['fireflies']:.2f} | {r['steady']:.0%} | {z} |"
        )
    if rows := [r for _, r in of(results, "coverage")]:
        mse, relmse = (mean([r["inside"][k] for r in rows]) for k in range(2))
        lines.append(f"| all | {mse:.1%} | {relmse:.1%} | | | | | | |")
    lines += [NOTES, MORE_SAMPLES] if of(results, "z") else [NOTES]
    for key, r in of(results, "z"):
        z = "–" if r["z"] is None else f"{r['z']:.2f}"
        lines.append(f"| {key} | {r['steady']:.0%} | {z} |")
    lines += [TARGET] if of(results, "targets") else []
    for key, r in of(results, "targets"):
        lines.append(f"| {key} | {r['target']:.3f} | {r['landed']:.2f} | {r['told']:.2f} |")
    if rows := [r for _, r in of(results, "targets")]:
        landed, told = (mean([r[k] for r in rows]) for k in ("landed", "told"))
        lines.append(f"| all | | {landed:.2f} | {told:.2f} |")
    lines += [FORETOLD] if of(results, "predictions") else []
    for key, r in of(results, "predictions"):
        spread = ", ".join(f"{x:.2f}" for x in r["foretold"])
        lines.append(
            f"| {key} | {r['made']:.0%} | {r['within']:.0%} | {r['limit']:.0%} | {spread} | {r['held']:.0%} |"
        )
    if rows := [r for _, r in of(results, "predictions")]:
        made, within, limit, held = (mean([r[k] for r in rows]) for k in ("made", "within", "limit", "held"))
        lines.append(f"| all | {made:.0%} | {within:.0%} | {limit:.0%} | | {held:.0%} |")
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
