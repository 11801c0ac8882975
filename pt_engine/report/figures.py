"""Figures of a page, as SVG text, and pictures as PNG; small enough to read on a phone."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .fits import tells
from .optional import optional

Float64 = NDArray[np.float64]
PURPOSE = "the report page"
SIZE = (4.6, 3.1)  # inches
COLOURS = ("#0b6bb8", "#c8501e", "#2a8a4a", "#7a4fa3", "#b8860b", "#d1495b", "#008b8b", "#555555")
DASHES = ("-", "--", ":", "-.")
STYLE = {
    "font.size": 10,
    "svg.fonttype": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "legend.fontsize": 9,
}


class Drawing:
    """A figure under way; `svg` is its text when it is done."""

    def __init__(self, axes: Any) -> None:
        self.axes, self.svg = axes, ""


@contextmanager
def drawing(name: str, size: tuple[float, float] = SIZE) -> Iterator[Drawing]:
    """A figure with one pair of axes; `name` keeps its identifiers apart from other figures' of the page."""
    matplotlib = optional("matplotlib", "matplotlib", PURPOSE)
    figure_class = optional("matplotlib.figure", "matplotlib", PURPOSE).Figure
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": name}):
        figure = figure_class(figsize=size, layout="constrained")
        made = Drawing(figure.add_subplot())
        yield made
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    made.svg = svg[svg.index("<svg") :].replace("<svg ", f'<svg role="img" aria-label="{name}" ', 1)


def curves(
    name: str,
    lines: Mapping[str, Sequence[Mapping[str, float]]],
    along: str = "seconds",
    least: float = 0.0,
) -> str:
    """MSE against core seconds or samples on log axes, with bands where the runs tell them.

    Below `least` the reference tells nothing: a dotted line.
    """
    with drawing(name, (SIZE[0], SIZE[1] + 0.18 * len(lines))) as made:
        axes = made.axes
        for number, (label, points) in enumerate(lines.items()):
            points = [p for p in points if p[along] > 0 and p["mse"] > 0]
            if not points:
                continue
            colour, dash = COLOURS[number % len(COLOURS)], DASHES[number // len(COLOURS) % len(DASHES)]
            x, y = ([p[key] for p in points] for key in (along, "mse"))
            axes.plot(x, y, dash, color=colour, label=label, linewidth=1.4, marker=".", markersize=4)
            band = [p for p in points if tells(p["low"], p["high"])]
            if band:
                x, low, high = ([p[key] for p in band] for key in (along, "low", "high"))
                axes.fill_between(x, low, high, color=colour, alpha=0.13, linewidth=0)
        if least > 0:
            axes.axhline(least, color="#888888", linestyle=":", linewidth=1)
        errors = [p["mse"] for points in lines.values() for p in points if p["mse"] > 0]
        axes.set(xscale="log", yscale="log", xlabel=AXES[along], ylabel="mean squared error")
        plain_ticks(axes.xaxis)
        if errors:
            axes.set_ylim(max(min(errors), least) / 3, 3 * max(*errors, least))
            axes.figure.legend(loc="outside lower center", ncols=2)
    return made.svg


def plain_ticks(axis: Any, scale: float = 1, unit: str = "") -> None:
    """1, 2, 5 on a log axis of few decades, only powers of ten on a longer one; no numbers between."""
    ticker = optional("matplotlib.ticker", "matplotlib", PURPOSE)
    low, high = axis.get_view_interval()
    few = high / low < 1e3
    axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5) if few else (1,)))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{scale * value:g}{unit}"))
    axis.set_minor_formatter(ticker.NullFormatter())


AXES = {"seconds": "core seconds", "samples": "samples per pixel"}


def convergence(
    history: Sequence[tuple[float, float]], now: tuple[float, float, float, float], times: float
) -> str:
    """A render's relative RMS error against seconds: noted on the way, now with its interval, and to come.

    Half of it takes so many `times` the samples.
    """
    seconds, error, low, high = now
    with drawing("error over time") as made:
        axes = made.axes
        if history:
            axes.plot(*zip(*history, strict=True), marker=".", color=COLOURS[0], label="estimated on the way")
        axes.errorbar(
            [seconds], [error], [[error - low], [high - error]], fmt="o", color=COLOURS[1], label="now, 95 %"
        )
        later = [seconds, times * seconds, times**2 * seconds]
        axes.plot(later, [error, error / 2, error / 4], "--", color="#888888", label="to come")
        axes.set(xscale="log", yscale="log", xlabel="seconds", ylabel="relative RMS error")
        plain_ticks(axes.xaxis)
        plain_ticks(axes.yaxis, 100, " %")
        axes.legend()
    return made.svg


def bars(name: str, rows: Sequence[tuple[str, float]], unit: str) -> str:
    """Horizontal bars, the first on top."""
    with drawing(name, (SIZE[0], 0.6 + 0.22 * len(rows))) as made:
        axes = made.axes
        values = [value for _, value in rows]
        axes.barh(range(len(rows)), values, color=COLOURS[0], height=0.7)
        for place, value in enumerate(values):  # at 0 where the bar goes to the left, which has names there
            axes.text(max(value, 0.0), place, f" {value:.3g}", fontsize=9, va="center")
        axes.set_yticks(range(len(rows)), [label for label, _ in rows])
        axes.invert_yaxis()
        axes.grid(False, axis="y")
        axes.margins(x=0.15)
        axes.set_xlabel(unit)
    return made.svg


def picture(image: Float64) -> str:
    """Linear radiance (height, width, 3), top row first, as an sRGB PNG in a data URL."""
    return png(srgb(image))


def jpeg(image: Float64, quality: int = 90) -> bytes:
    """The same as a JPEG: noise makes PNGs large."""
    imaging = optional("matplotlib.image", "matplotlib", PURPOSE)
    stream = io.BytesIO()
    how = {"format": "jpeg", "pil_kwargs": {"quality": quality}}
    imaging.imsave(stream, np.ascontiguousarray(srgb(image)), **how)
    return stream.getvalue()


def srgb(image: Float64) -> Float64:
    """Linear radiance as display values in [0, 1]."""
    c = np.clip(image, 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, 0.0031308) ** (1 / 2.4) - 0.055)


def heat(values: Float64, most: float) -> str:
    """Numbers (height, width), top row first, in colours from 0 to `most`, as a PNG in a data URL."""
    colours = optional("matplotlib", "matplotlib", PURPOSE).colormaps["magma"]
    return png(colours(np.clip(np.nan_to_num(values) / (most or 1.0), 0, 1))[..., :3])


def png(image: Float64) -> str:
    """Display values (height, width, 3) in [0, 1] as a data URL."""
    imaging = optional("matplotlib.image", "matplotlib", PURPOSE)
    stream = io.BytesIO()
    imaging.imsave(stream, np.ascontiguousarray(image), format="png")
    return data_url(stream.getvalue())


def data_url(content: bytes) -> str:
    """A PNG's bytes as a link that carries them."""
    return "data:image/png;base64," + base64.b64encode(content).decode("ascii")
