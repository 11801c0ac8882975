"""Numbers: Math, Map Range, Clamp, Fresnel and Layer Weight. Formulas as in Cycles' kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, VECTOR, Value, lane_op, op
from .registry import Outputs, node

Float32 = NDArray[np.float32]
TINY = np.float32(1e-5)
EPSILON = np.float32(1.1920929e-07)


def select(condition: Any, yes: Any, no: Any) -> Float32:
    """yes where condition, else no."""
    chosen: Float32 = np.where(condition, yes, no).astype(np.float32, copy=False)
    return chosen


def divide(a: Float32, b: Float32) -> Float32:
    """a / b, 0 where b is 0."""
    zero = b == 0
    return select(zero, np.float32(0), a / (b + zero))


def power(a: Float32, b: Float32) -> Float32:
    """a to the power b: 1 where b is 0; 0 where a is 0, or negative and b no integer."""
    bad = ((a < 0) & (b != np.trunc(b))) | ((a == 0) & (b != 0))
    return select(bad, np.float32(0), np.power(select(bad, np.float32(1), a), b))


def safe_logarithm(a: Float32, b: Float32) -> Float32:
    """log_b a, 0 where either is not positive or b is 1."""
    usable = (a > 0) & (b > 0)
    return select(usable, divide(np.log(select(usable, a, 1)), np.log(select(usable, b, 1))), 0)


def modulo(a: Float32, b: Float32) -> Float32:
    """C's fmod, 0 where b is 0."""
    zero = b == 0
    return select(zero, np.float32(0), np.fmod(a, b + zero))


def floored_modulo(a: Float32, b: Float32) -> Float32:
    """a − b·floor(a/b), 0 where b is 0."""
    zero = b == 0
    return select(zero, np.float32(0), a - np.floor(a / (b + zero)) * b)


def wrap(value: Float32, high: Float32, low: Float32) -> Float32:
    """value moved into [low, high) by whole ranges."""
    span = high - low
    zero = span == 0
    return select(zero, low, value - span * np.floor((value - low) / (span + zero)))


def pingpong(a: Float32, b: Float32) -> Float32:
    """A triangle wave of height b."""
    zero = b == 0
    s = (a - b) / (2 * b + zero)
    return select(zero, np.float32(0), np.abs((s - np.floor(s)) * b * 2 - b))


def smooth_minimum(a: Float32, b: Float32, c: Float32) -> Float32:
    """min(a, b) with a blend of width c (Quilez' cubic)."""
    zero = c == 0
    h = np.maximum(c - np.abs(a - b), 0) / (c + zero)
    return np.minimum(a, b) - select(zero, np.float32(0), h * h * h * c * np.float32(1 / 6))


def round_half_up(a: Float32) -> Float32:
    """floor(a + ½)."""
    return np.floor(a + np.float32(0.5))


def flag(condition: Any) -> Float32:
    """1 where true."""
    return np.asarray(condition).astype(np.float32)


MATH: dict[str, Callable[[Float32, Float32, Float32], Any]] = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: power(a, b),
    "LOGARITHM": lambda a, b, c: safe_logarithm(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "INVERSE_SQRT": lambda a, b, c: select(a > 0, 1 / np.sqrt(select(a > 0, a, 1)), 0),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.fmin(a, b),
    "MAXIMUM": lambda a, b, c: np.fmax(a, b),
    "LESS_THAN": lambda a, b, c: flag(a < b),
    "GREATER_THAN": lambda a, b, c: flag(a > b),
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": lambda a, b, c: flag((a == b) | (np.abs(a - b) <= np.fmax(c, EPSILON))),
    "SMOOTH_MIN": smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -smooth_minimum(-a, -b, c),
    "ROUND": lambda a, b, c: round_half_up(a),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: modulo(a, b),
    "FLOORED_MODULO": lambda a, b, c: floored_modulo(a, b),
    "WRAP": wrap,
    "SNAP": lambda a, b, c: np.floor(divide(a, b)) * b,
    "PINGPONG": lambda a, b, c: pingpong(a, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1, 1)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1, 1)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: a * np.float32(np.pi / 180),
    "DEGREES": lambda a, b, c: a * np.float32(180 / np.pi),
}


@op(FLOAT)
def math(operation: str, a: Float32, b: Float32, c: Float32) -> Float32:
    """One of the Math node's operations."""
    return MATH[operation](a, b, c)  # type: ignore[no-any-return]


@op(FLOAT)
def saturate(a: Float32) -> Float32:
    """Clamped to [0, 1]."""
    return np.minimum(np.maximum(a, 0), 1)


@op(FLOAT)
def at_least(a: Float32, low: Float32) -> Float32:
    """max(a, low)."""
    return np.maximum(a, low)


@node("Math")
def math_node(n: NodeView) -> Outputs:
    operation = str(n.prop("operation", "ADD"))
    if operation not in MATH:
        n.ignored(f"operation {operation} is not understood: 0")
        return {"Value": n.constant(0.0, FLOAT)}
    inputs = [n.float("Value", 0.5), n.float("Value_001", 0.5), n.float("Value_002", 0.5)]
    out = n.call(math, *inputs, static=(operation,))
    return {"Value": n.call(saturate, out) if n.prop("use_clamp", False) else out}


# ------------------------------------------------------------------ ranges


def smooth_step(t: Float32) -> Float32:
    """3t² − 2t³."""
    return t * t * (3 - 2 * t)


def smoother_step(t: Float32) -> Float32:
    """6t⁵ − 15t⁴ + 10t³."""
    return t * t * t * (t * (t * 6 - 15) + 10)


def step_fraction(kind: str, value: Float32, low: Float32, high: Float32, steps: Float32) -> Float32:
    """Where value lies between low and high, by the node's interpolation."""
    t = divide(value - low, high - low)
    if kind == "STEPPED":
        some = steps > 0
        return select(some, np.floor(t * (steps + 1)) / select(some, steps, 1), 0)
    if kind == "SMOOTHSTEP":
        return smooth_step(np.clip(t, 0, 1))
    if kind == "SMOOTHERSTEP":
        return smoother_step(np.clip(t, 0, 1))
    return t


@op(FLOAT)
def map_range(kind: str, clamp: bool, *inputs: Float32) -> Float32:
    """Map Range on numbers."""
    value, low, high, to_low, to_high, steps = inputs
    out = to_low + step_fraction(kind, value, low, high, steps) * (to_high - to_low)
    out = select(low == high, np.float32(0), out)
    return _between(out, to_low, to_high) if clamp and kind in ("LINEAR", "STEPPED") else out


@op(VECTOR)
def map_range_vector(kind: str, clamp: bool, *inputs: Float32) -> Float32:
    """Map Range on vectors, component by component."""
    value, low, high, to_low, to_high, steps = inputs
    out = to_low + step_fraction(kind, value, low, high, steps) * (to_high - to_low)
    return _between(out, to_low, to_high) if clamp and kind in ("LINEAR", "STEPPED") else out


def _between(x: Float32, a: Float32, b: Float32) -> Float32:
    return np.minimum(np.maximum(x, np.minimum(a, b)), np.maximum(a, b))


@node("MapRange")
def map_range_node(n: NodeView) -> Outputs:
    static = (str(n.prop("interpolation_type", "LINEAR")), bool(n.prop("clamp", True)))
    if n.prop("data_type", "FLOAT") == "FLOAT_VECTOR":
        vectors_in: list[Value] = [
            n.vector("Vector"),
            n.vector("From_Min_FLOAT3"),
            n.vector("From_Max_FLOAT3", 1.0),
            n.vector("To_Min_FLOAT3"),
            n.vector("To_Max_FLOAT3", 1.0),
            n.vector("Steps_FLOAT3", 4.0),
        ]
        return {"Vector": n.call(map_range_vector, *vectors_in, static=static)}
    inputs = [
        n.float("Value", 1.0),
        n.float("From Min"),
        n.float("From Max", 1.0),
        n.float("To Min"),
        n.float("To Max", 1.0),
        n.float("Steps", 4.0),
    ]
    return {"Result": n.call(map_range, *inputs, static=static)}


@op(FLOAT)
def clamp(kind: str, value: Float32, low: Float32, high: Float32) -> Float32:
    """Clamp; RANGE takes the bounds in either order."""
    if kind == "RANGE":
        return _between(value, low, high)
    return np.minimum(np.maximum(value, low), high)


@node("Clamp")
def clamp_node(n: NodeView) -> Outputs:
    inputs = [n.float("Value", 1.0), n.float("Min", 0.0), n.float("Max", 1.0)]
    return {"Result": n.call(clamp, *inputs, static=(str(n.prop("clamp_type", "MINMAX")),))}


# ------------------------------------------------------------------ Fresnel


def fresnel_dielectric(cos_i: Float32, eta: Float32) -> Float32:
    """Unpolarised reflectance of a dielectric of relative index eta; 1 under total reflection."""
    c = np.abs(cos_i)
    g2 = eta * eta - 1 + c * c
    g = np.sqrt(np.maximum(g2, 0))
    a = (g - c) / np.maximum(g + c, np.float32(1e-20))
    below = c * (g - c) + 1
    b = (c * (g + c) - 1) / (below + (below == 0))
    return select(g2 > 0, 0.5 * a * a * (1 + b * b), np.float32(1))


@lane_op(FLOAT)
def fresnel(lanes: Any, ior: Float32, *normal: Float32) -> Float32:
    """The Fresnel node: reflectance at the viewer's angle."""
    eta = np.maximum(ior, TINY)
    eta = eta + lanes.backfacing * (1 / eta - eta)
    return fresnel_dielectric(vectors.dot(lanes.wi, normal[0] if normal else lanes.ns), eta)


@lane_op(FLOAT)
def layer_fresnel(lanes: Any, blend: Float32, *normal: Float32) -> Float32:
    """Layer Weight's Fresnel: index 1/(1 − blend)."""
    eta = np.maximum(1 - blend, TINY)
    eta = 1 / eta + lanes.backfacing * (eta - 1 / eta)
    return fresnel_dielectric(vectors.dot(lanes.wi, normal[0] if normal else lanes.ns), eta)


@lane_op(FLOAT)
def layer_facing(lanes: Any, blend: Float32, *normal: Float32) -> Float32:
    """Layer Weight's Facing: 1 − |cosθ|^e, e = 2·blend up to ½, then ½/(1 − blend)."""
    c = np.abs(vectors.dot(lanes.wi, normal[0] if normal else lanes.ns))
    b = np.clip(blend, 0, 1 - TINY)
    exponent = select(b < 0.5, 2 * b, 0.5 / (1 - b))
    return 1 - c**exponent


def _normal(n: NodeView) -> tuple[Value, ...]:
    normal = n.normal()
    return () if normal is None else (normal,)


@node("Fresnel")
def fresnel_node(n: NodeView) -> Outputs:
    return {"Fac": n.call(fresnel, n.float("IOR", 1.5), *_normal(n))}


@node("LayerWeight")
def layer_weight_node(n: NodeView) -> Outputs:
    inputs = (n.float("Blend", 0.5), *_normal(n))
    table = {"Fresnel": layer_fresnel, "Facing": layer_facing}
    return {name: n.call(what, *inputs) for name, what in table.items() if n.wants(name)}
