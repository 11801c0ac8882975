"""Curves of constants as Blender folds them: by tables of their own, straight beyond; Float Curve clipped."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, op

Float32 = NDArray[np.float32]
Tables = tuple[tuple[float, ...], ...]  # see `export.curve_nodes.folded`


def at(table: tuple[float, ...], x: Float32) -> Float32:
    """A curve at x: linear between its samples, and along the straight lines that it has beyond them."""
    low, high, before, falling, after, rising, *values = table
    inside = np.interp(x, np.linspace(low, high, len(values)), values)
    below, above = before + falling * (x - low), after + rising * (x - high)
    return np.where(x < low, below, np.where(x > high, above, inside)).astype(np.float32)


@op(COLOR)
def folded_color(tables: Tables, t: Float32, x: Float32) -> Float32:
    """RGB Curves: the common curve first."""
    return mixed(x, np.stack([at(tables[k], at(tables[3], x[k])) for k in range(3)]), t)


@op(VECTOR)
def folded_vector(tables: Tables, t: Float32, x: Float32) -> Float32:
    """Vector Curves."""
    return mixed(x, np.stack([at(tables[k], x[k]) for k in range(3)]), t)


@op(FLOAT)
def folded_float(tables: Tables, clip: tuple[float, float] | None, t: Float32, x: Float32) -> Float32:
    """Float Curve."""
    y = at(tables[0], x)
    if clip is not None:
        y = np.clip(y, np.float32(clip[0]), np.float32(clip[1]))
    return mixed(x, y, t)


def mixed(x: Float32, y: Float32, t: Float32) -> Float32:
    """From x to y by t."""
    out: Float32 = x * (1 - t) + y * t
    return out


def folded_curve(n: NodeView, what: Any, t: Value, x: Value) -> Value | None:
    """The node's curve where Blender has folded it, else None."""
    tables = n.node.props.get("folded_curves")
    if tables is None:
        return None
    clip = (n.node.props.get("folded_clip"),) if what is folded_float else ()
    return n.call(what, t, x, static=(tables, *clip))
