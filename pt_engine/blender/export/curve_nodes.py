"""Curves of RGB, Vector and Float Curve as tables: as Cycles samples them, and as Blender folds them.

Cycles gets 257 samples over the range that all points span. A node whose inputs are constants it never sees:
Blender folds it by each curve's own table, which spans the editor's range as well, goes on as the curve does
beyond, and, of a Float Curve alone, is clipped.
"""

from __future__ import annotations

SAMPLES = 257


def curves(mapping, kind: str) -> dict[str, object]:
    """What `node_props` says of a node's curves."""
    mapping.initialize()
    channels = list(mapping.curves)
    count = 1 if kind == "ShaderNodeFloatCurve" else 3
    spanning = channels[:4] if kind == "ShaderNodeRGBCurve" else channels[:count]
    first = min(curve.points[0].location[0] for curve in spanning)
    last = max(curve.points[len(curve.points) - 1].location[0] for curve in spanning)
    steps = samples(first, last)
    if kind == "ShaderNodeRGBCurve":
        steps = [mapping.evaluate(channels[3], x) for x in steps]
    clipped = kind == "ShaderNodeFloatCurve" and mapping.use_clip
    return {
        "curves": tuple(tuple(mapping.evaluate(curve, x) for x in steps) for curve in channels[:count]),
        "curve_range": (first, last),
        "curve_extend": mapping.extend,
        "folded_curves": tuple(folded(mapping, curve) for curve in spanning),
        "folded_clip": (mapping.clip_min_y, mapping.clip_max_y) if clipped else None,
    }


def samples(first: float, last: float) -> list[float]:
    """Where a table looks."""
    return [first + (last - first) * i / (SAMPLES - 1) for i in range(SAMPLES)]


def folded(mapping, curve) -> tuple[float, ...]:
    """A curve's own table: where it begins and ends, the lines before and after, and what it holds.

    A line is its value at that end and its slope; where the curve ends upright it does not meet the table.
    """
    first = min(mapping.clip_min_x, curve.points[0].location[0])
    last = max(mapping.clip_max_x, curve.points[len(curve.points) - 1].location[0])
    values = [mapping.evaluate(curve, x) for x in samples(first, last)]
    return first, last, *line(mapping, curve, first, -1), *line(mapping, curve, last, 1), *values


def line(mapping, curve, end: float, way: int) -> tuple[float, float]:
    """What a curve beyond an end comes to there, and its slope."""
    near, far = (mapping.evaluate(curve, end + k * way) for k in (1, 2))
    return 2 * near - far, (far - near) * way
