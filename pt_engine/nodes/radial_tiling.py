"""Radial Tiling: a plane cut into the segments of a regular polygon with rounded corners.

A segment spans the angles within a = π/sides of its bisector; with a broken number of sides the last one is
narrower, b = π − ⌊sides⌋ a. At distance l and angle δ from the bisector, L is how far out the polygon through
the point crosses the bisector, and u runs along the polygon:

    straight   L = l cosδ                  u = L tan|δ|
    rounded    L = l/R(ν)                  u = l sinγ + (spline of c = β − ν)           ν = half − |δ| < β

β is the angle, from the segment's border, at which its corner begins, γ the rest up to the bisector; R the
corner's circle as seen from the centre. Corners between the narrow segment and its neighbours have circles of
their own, tangent to both sides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .graph import NodeView
from .ir import FLOAT, VECTOR, op
from .math_nodes import select
from .registry import Outputs, node

Float32 = NDArray[np.float32]
PI = np.float32(np.pi)
TURN = np.float32(2 * np.pi)
HALF = np.float32(0.5)


class Segment(NamedTuple):
    """The segment each lane is in.

    Attributes
    ----------
    start : (N,) float32
        Angle at which it begins.
    half, offset : (N,) float32
        Half its width, and the lane's angle from its bisector.
    bevel, roundness : (N,) float32
        β, and how much of it is a circle's arc.
    stretch : (N,) float32
        How much further out the regular polygon crosses its bisector than the narrow segment's.
    center_x, center_y, radius, scale : (N,) float32
        The circle of the corner, in a frame along the border with y to the lane's side of it, and the L of
        the polygon that it belongs to.
    is_last : (N,) bool
    width : (N,) float32
        Largest u where L is 1.
    """

    start: Float32
    half: Float32
    offset: Float32
    bevel: Float32
    roundness: Float32
    stretch: Float32
    center_x: Float32
    center_y: Float32
    radius: Float32
    scale: Float32
    is_last: NDArray[np.bool_]
    width: Float32


def angle_of(p: Float32) -> Float32:
    """In [0, 2π) from the x axis."""
    angle: Float32 = np.arctan2(p[1], p[0]) + (p[1] < 0) * TURN
    return angle


def bevel_of(half: Float32, roundness: Float32) -> Float32:
    """The angle from a segment's border at which a corner begins."""
    return half - np.arctan((1 - roundness) * np.tan(half))


def segment_of(p: Float32, sides: Float32, roundness: Float32) -> Segment:
    """Where the lanes are."""
    theta, a = angle_of(p), PI / sides
    number = np.floor(theta / (2 * a))
    start = number * (2 * a)
    broken = sides != np.floor(sides)
    b = PI - np.floor(sides) * a
    end = TURN - 2 * b  # where the narrow segment begins
    is_last = broken & (theta >= end)
    beside = broken & ~is_last & ((theta < a) | (theta >= end - a))
    bevel_a, bevel_b = bevel_of(a, roundness), bevel_of(b, roundness)
    x, y, radius = corner_beside(a, b, bevel_b, roundness)
    outer = np.arctan((y + radius * np.sin(a)) / (x + radius * np.cos(a)))
    of_outer = 1 - np.tan(a - outer) / np.tan(a)
    odd = is_last | beside
    wider = np.cos(a) / np.cos(b)
    stretch = select(is_last, wider, np.float32(1))
    half = select(is_last, b, a)
    whole = edge(a, bevel_a, roundness)
    narrow = np.tan(b - bevel_b) + (1 - roundness) * bevel_b * (HALF + HALF * stretch)
    narrow = narrow + stretch * roundness * bevel_b
    return Segment(
        start=start,
        half=half,
        offset=theta - start - half,
        bevel=select(is_last, bevel_b, select(beside, outer, bevel_a)),
        roundness=select(beside, of_outer, roundness),
        stretch=stretch,
        center_x=select(odd, x, (1 - roundness) / np.cos(a)),
        center_y=select(odd, select(is_last, -y, y), np.float32(0)),
        radius=select(odd, radius, roundness),
        scale=select(beside, wider, np.float32(1)),
        is_last=is_last,
        width=select(is_last, narrow, whole),
    )


def corner_beside(a: Float32, b: Float32, bevel: Float32, roundness: Float32) -> Float32:
    """(3, N) centre and radius of the circle between the first segment and the narrow one before it."""
    radius = roundness * np.tan(b) / np.tan(HALF * (a + b))
    far = np.cos(b - bevel)
    x = np.cos(bevel) / far - radius * np.cos(b)
    y = radius * np.sin(b) - np.sin(bevel) / far
    return np.stack([x, y, radius]).astype(np.float32, copy=False)


def edge(half: Float32, bevel: Float32, roundness: Float32) -> Float32:
    """u from the bisector to the border, at L = 1."""
    width: Float32 = np.tan(half - bevel) + (1 - roundness) * bevel + roundness * bevel
    return width


def along(s: Segment, length: Float32, crossing: Float32, rounded: NDArray[np.bool_]) -> Float32:
    """|u| over the stretch, not normalised."""
    rest = s.half - s.bevel
    spline = (1 - s.roundness) * s.bevel
    c = s.bevel - (s.half - np.abs(s.offset))
    reach = length * np.cos(rest)
    bent = reach * c + HALF * (1 - reach) * c * c / np.maximum(spline, np.float32(1e-30))
    arc = spline * (HALF * reach - HALF) + c
    corner = length * np.sin(rest) + select(c < spline, bent, arc)
    return select(rounded, corner, crossing * np.tan(np.abs(s.offset)))


def largest(s: Segment, length: Float32, crossing: Float32, rounded: NDArray[np.bool_]) -> Float32:
    """What |u| over the stretch comes to at the border, for the polygon through the point."""
    rest = s.half - s.bevel
    spline, arc = (1 - s.roundness) * s.bevel, s.roundness * s.bevel
    straight = crossing * np.tan(rest) + spline * (HALF * crossing + HALF) + arc
    circle = length * np.sin(rest) + spline * (HALF * length * np.cos(rest) + HALF) + arc
    c = s.bevel - (s.half - np.abs(s.offset))
    share = select(rounded, c / (s.bevel + (s.bevel == 0)), np.float32(0))
    mixed: Float32 = straight + share * (circle - straight)
    return mixed


@op(VECTOR, FLOAT, FLOAT, FLOAT)
def radial_tiling(
    normalize: bool, vector: Float32, sides: Float32, roundness: Float32
) -> tuple[Float32, Float32, Float32, Float32]:
    """(u, L, 0), the segment's number, its width and its bisector's angle."""
    n = np.broadcast_shapes(vector.shape[1:], sides.shape, roundness.shape)
    p = np.broadcast_to(vector, (3, *n))
    sides = np.broadcast_to(np.maximum(sides, 2), n)
    roundness = np.broadcast_to(np.clip(roundness, 0, 1), n)
    s = segment_of(p, sides, roundness)
    flat = (sides == 2) & (roundness == 0)  # two half planes, endlessly wide
    length = np.sqrt(p[0] * p[0] + p[1] * p[1])
    nu = s.half - np.abs(s.offset)
    rounded = (nu < s.bevel) & (roundness > 0)
    toward = np.cos(nu) * s.center_x + np.sin(nu) * s.center_y
    inside = toward * toward + s.radius * s.radius - s.center_x * s.center_x - s.center_y * s.center_y
    distance = toward + np.sqrt(np.maximum(inside, 0))
    corner = s.scale * length / (distance + (distance == 0))
    crossing = select(rounded, corner, length * np.cos(s.offset))
    u = along(s, length, crossing, rounded) * s.stretch
    if normalize:
        most = largest(s, length, crossing, rounded) * s.stretch
        u = u / select(flat | (most == 0), np.float32(1), most)
    u = np.where(s.offset < 0, -u, u) * ((p[0] != 0) | (p[1] != 0))
    out = s.stretch * crossing
    u, out = (HALF * u + HALF, out) if normalize else (u, out - 1)
    number = np.floor(sides * (np.arctan2(p[1], p[0]) / TURN + (p[1] < 0)))
    width = select(flat, np.float32(0), s.width)
    lost = rounded & ~(inside >= 0)  # less than two sides: no circle fits, and Cycles' film is black
    u, out = select(lost & normalize, np.float32(0), u), select(lost, np.float32(0), out)
    at = np.stack([u, out, np.zeros_like(u)])
    return at, number.astype(np.float32, copy=False), width, s.start + s.half


@node("RadialTiling")
def radial_tiling_node(n: NodeView) -> Outputs:
    static = (bool(n.prop("normalize", False)),)
    inputs = n.vector("Vector"), n.float("Sides", 5.0), n.float("Roundness")
    names = ("Segment Coordinates", "Segment ID", "Segment Width", "Segment Rotation")
    return dict(zip(names, n.calls(radial_tiling, *inputs, static=static), strict=True))
