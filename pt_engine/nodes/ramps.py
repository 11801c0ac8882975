"""Colour ramps and curves: tables of 257 samples, looked up as Cycles does."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .color_spaces import hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv
from .folded_curves import folded_color, folded_curve, folded_float, folded_vector
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, op
from .registry import Outputs, node

Float32 = NDArray[np.float32]
SAMPLES = 257  # of a colour ramp, as Blender hands it to Cycles

Stops = tuple[tuple[float, ...], ...]


# ------------------------------------------------------------------ colour ramps


def ramp_table(mode: str, interpolation: str, stops: Stops, hue_mode: str = "NEAR") -> Float32:
    """(4, 257) RGBA of a ramp at positions k/256."""
    return ramp_at(np.linspace(0, 1, SAMPLES, dtype=np.float64), mode, interpolation, stops, hue_mode)


def ramp_at(
    at: NDArray[np.float64], mode: str, interpolation: str, stops: Stops, hue_mode: str = "NEAR"
) -> Float32:
    """(4, n) RGBA of a ramp at positions (n,)."""
    if not stops:
        return np.zeros((4, len(at)), np.float32)
    positions = np.array([s[0] for s in stops], np.float64)
    colors = np.array([s[1:5] for s in stops], np.float64).T
    if len(stops) == 1:
        return np.repeat(colors, len(at), axis=1).astype(np.float32)
    if mode in ("HSV", "HSL"):
        return _hue_table(mode, positions, colors, at, hue_mode).astype(np.float32)
    if interpolation == "CONSTANT":
        return colors[:, _before(positions, at)].astype(np.float32)
    if interpolation in ("CARDINAL", "B_SPLINE"):
        return _spline_table(interpolation, positions, colors, at).astype(np.float32)
    left, right, t = _span(positions, at)
    if interpolation == "EASE":
        t = t * t * (3 - 2 * t)
    return (colors[:, left] * (1 - t) + colors[:, right] * t).astype(np.float32)


def _before(positions: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.intp]:
    left = np.maximum(np.searchsorted(positions, at, side="right") - 1, 0)
    return np.where(at <= positions[0], 0, left)


def _span(
    positions: NDArray[np.float64], at: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """The stops on either side, and how far between them; up to the first stop it is its colour."""
    right = np.where(at <= positions[0], 0, np.searchsorted(positions, at, side="right"))
    left = np.clip(right - 1, 0, len(positions) - 1)
    right = np.clip(right, 0, len(positions) - 1)
    width = positions[right] - positions[left]
    t = np.clip((at - positions[left]) / np.where(width > 0, width, 1), 0, 1)
    return left, right, np.where(width > 0, t, 0)


def _spline_table(
    kind: str, positions: NDArray[np.float64], colors: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Cubic through (CARDINAL, tension 0.71) or near (B_SPLINE) the stops.

    The first colour also stands at 0 and the last at 1, so that the curve goes on to both ends. Where such a
    stretch has no length, the curve is at the stop.
    """
    left = np.searchsorted(positions, at, side="right")
    right, last = left + 1, len(positions) + 1
    positions = np.concatenate([[0.0], positions, [1.0]])
    colors = np.concatenate([colors[:, :1], colors, colors[:, -1:]], axis=1)
    before, after = np.maximum(left - 1, 0), np.minimum(right + 1, last)
    width = positions[right] - positions[left]
    some = width != 0
    t = np.where(some, np.clip((at - positions[left]) / np.where(some, width, 1), 0, 1), right < last)
    if kind == "CARDINAL":
        f = 0.71
        weights = (
            ((-f * t + 2 * f) * t - f) * t,
            ((2 - f) * t + (f - 3)) * t * t + 1,
            (((f - 2) * t + (3 - 2 * f)) * t + f) * t,
            (f * t - f) * t * t,
        )
    else:
        weights = (
            ((-t / 6 + 0.5) * t - 0.5) * t + 1 / 6,
            (0.5 * t - 1) * t * t + 2 / 3,
            ((-0.5 * t + 0.5) * t + 0.5) * t + 1 / 6,
            t * t * t / 6,
        )
    first, second, third, fourth = (
        w * colors[:, i] for w, i in zip(weights, (before, left, right, after), strict=True)
    )
    return np.clip(first + second + third + fourth, 0, 1)


def _hue_table(
    mode: str,
    positions: NDArray[np.float64],
    colors: NDArray[np.float64],
    at: NDArray[np.float64],
    hue_mode: str,
) -> NDArray[np.float64]:
    """Linear in HSV or HSL, the hue going round by `hue_mode`."""
    forth, back = (rgb_to_hsv, hsv_to_rgb) if mode == "HSV" else (rgb_to_hsl, hsl_to_rgb)
    space = forth(colors[:3].astype(np.float32)).astype(np.float64)
    left, right, t = _span(positions, at)
    a, b = space[0, left], space[0, right]
    way = b - a
    if hue_mode == "NEAR":
        way = way - np.round(way)
    elif hue_mode == "FAR":
        way = np.where(way == 0, way, np.where(np.abs(way) < 0.5, way - np.sign(way), way))
    elif hue_mode == "CW":
        way = np.where(way < 0, way + 1, way)
    elif hue_mode == "CCW":
        way = np.where(way > 0, way - 1, way)
    hue = (a + way * t) % 1.0
    rest = space[1:, left] * (1 - t) + space[1:, right] * t
    rgb = back(np.vstack([hue[None], rest]).astype(np.float32))
    alpha = colors[3:, left] * (1 - t) + colors[3:, right] * t
    return np.vstack([rgb.astype(np.float64), alpha])


class Table:
    """A lookup table, compared by content so that equal ramps share programs.

    Attributes
    ----------
    channels, rises : (C, K) float32
        Samples, and how much more the next one is; 0 after the last.
    """

    def __init__(self, values: Float32) -> None:
        self.channels = np.ascontiguousarray(values, np.float32)
        self.rises = np.diff(self.channels, axis=1, append=self.channels[:, -1:])
        self._key = (self.channels.shape, self.channels.tobytes())

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and other._key == self._key

    def at(self, f: Float32, smooth: bool) -> Float32:
        """(C, n) at f, clamped to [0, 1]; linear between samples where `smooth`."""
        place, beyond = self.place(f)
        out = np.empty((len(self.channels), f.size), np.float32)
        for row, samples, rises in zip(out, self.channels, self.rises, strict=True):
            samples.take(place, out=row, mode="clip")
            if smooth:
                row += beyond * rises.take(place, mode="clip")
        return out

    def place(self, f: Float32) -> tuple[NDArray[np.intp], Float32]:
        """(n,) the last sample before f, clamped to [0, 1], and how far beyond it f is, in steps."""
        x = np.fmin(np.fmax(f, 0), 1) * np.float32(self.channels.shape[1] - 1)
        low = np.floor(x)
        return low.astype(np.intp), x - low


@op(COLOR, FLOAT)
def ramp(table: Table, smooth: bool, f: Float32) -> tuple[Float32, Float32]:
    """Colour and alpha of a ramp."""
    rgba = table.at(f, smooth)
    return rgba[:3], rgba[3]


@op(COLOR, FLOAT)
def folded_ramp(ramp: tuple[Any, ...], f: Float32) -> tuple[Float32, Float32]:
    """Colour and alpha of a ramp at a constant, as Blender folds it: without a table."""
    rgba = ramp_at(f.astype(np.float64), *ramp)
    return rgba[:3], rgba[3]


@node("ValToRGB")
def color_ramp_node(n: NodeView) -> Outputs:
    mode, interpolation, stops = n.prop("ramp", ("RGB", "LINEAR", ((0, 0, 0, 0, 1), (1, 1, 1, 1, 1))))
    settings = mode, interpolation, stops, str(n.prop("ramp_hue", "NEAR"))
    if n.prop("folded", False):
        color, alpha = n.calls(folded_ramp, n.float("Fac", 0.5), static=(settings,))
    else:
        static = Table(ramp_table(*settings)), interpolation != "CONSTANT"
        color, alpha = n.calls(ramp, n.float("Fac", 0.5), static=static)
    return {"Color": color, "Alpha": alpha}


# ------------------------------------------------------------------ curves


def curve(table: Table, channel: int, low: float, high: float, extend: bool, x: Float32) -> Float32:
    """One channel of a curve; past its ends flat, or on along its last stretch where `extend`."""
    span = high - low
    f = (x - np.float32(low)) * np.float32(1 / span if span else 0)
    samples, rises = table.channels[channel], table.rises[channel]
    place, beyond = table.place(f)
    out: Float32 = samples.take(place, mode="clip") + beyond * rises.take(place, mode="clip")
    if extend:
        last = np.float32(len(samples) - 1)
        first_slope, last_slope = rises[0] * last, rises[-2] * last
        out = out + np.minimum(f, 0) * first_slope + np.maximum(f - 1, 0) * last_slope
    return out


def _curves(table: Table, low: float, high: float, extend: bool, t: Float32, x: Float32) -> Float32:
    curved = np.stack([curve(table, k, low, high, extend, x[k]) for k in range(3)])
    out: Float32 = x * (1 - t) + curved * t
    return out


@op(COLOR)
def curves_color(table: Table, low: float, high: float, extend: bool, t: Float32, x: Float32) -> Float32:
    """RGB Curves, mixed in by t."""
    return _curves(table, low, high, extend, t, x)


@op(VECTOR)
def curves_vector(table: Table, low: float, high: float, extend: bool, t: Float32, x: Float32) -> Float32:
    """Vector Curves, mixed in by t."""
    return _curves(table, low, high, extend, t, x)


@op(FLOAT)
def curve_float(table: Table, low: float, high: float, extend: bool, t: Float32, x: Float32) -> Float32:
    """Float Curve, mixed in by t."""
    out: Float32 = x * (1 - t) + curve(table, 0, low, high, extend, x) * t
    return out


def curve_static(n: NodeView, channels: int) -> tuple[Any, ...] | None:
    """Table, range and extension of a node's curves; None where they are missing."""
    tables = n.node.props.get("curves")
    if not isinstance(tables, tuple) or len(tables) < channels:
        n.ignored("the curve is missing: the input passes through")
        return None
    low, high = n.prop("curve_range", (0.0, 1.0))
    extend = n.prop("curve_extend", "HORIZONTAL") == "EXTRAPOLATED"
    return Table(np.array(tables[:channels], np.float32)), float(low), float(high), extend


def _curve_node(n: NodeView, what: Any, folded: Any, channels: int, t: Value, x: Value) -> Value:
    constant = folded_curve(n, folded, t, x)
    if constant is not None:
        return constant
    static = curve_static(n, channels)
    return x if static is None else n.call(what, t, x, static=static)


@node("RGBCurve")
def rgb_curve_node(n: NodeView) -> Outputs:
    return {
        "Color": _curve_node(n, curves_color, folded_color, 3, n.float("Fac", 1.0), n.color("Color", 1.0))
    }


@node("VectorCurve")
def vector_curve_node(n: NodeView) -> Outputs:
    return {
        "Vector": _curve_node(n, curves_vector, folded_vector, 3, n.float("Fac", 1.0), n.vector("Vector"))
    }


@node("FloatCurve")
def float_curve_node(n: NodeView) -> Outputs:
    return {
        "Value": _curve_node(n, curve_float, folded_float, 1, n.float("Factor", 1.0), n.float("Value", 1.0))
    }
