"""Procedural patterns without noise: Checker, Brick, Gradient, Magic, White Noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import hashes
from .coordinates import coordinates
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, mean, op, spread_color
from .math_nodes import divide, select, smooth_step
from .registry import Outputs, node
from .vector_nodes import separate

Float32 = NDArray[np.float32]


def scaled(n: NodeView, default: float = 5.0) -> Value:
    """Coordinates times Scale."""
    return n.call(times, coordinates(n), n.float("Scale", default))


@op(VECTOR)
def times(v: Float32, s: Float32) -> Float32:
    """v·s."""
    out: Float32 = v * s
    return out


# ------------------------------------------------------------------ Checker


@op(FLOAT)
def checker(p: Float32) -> Float32:
    """1 and 0 in turn over unit cubes."""
    cell = np.abs(np.floor((p + np.float32(1e-6)) * np.float32(0.999999))).astype(np.int32) & 1
    out: Float32 = ((cell[0] == cell[1]) == (cell[2] == 1)).astype(np.float32)
    return out


@op(COLOR)
def either(f: Float32, one: Float32, other: Float32) -> Float32:
    """`one` where f is 1, `other` where it is 0."""
    return select(f == 1, one, other)


@node("TexChecker")
def tex_checker(n: NodeView) -> Outputs:
    f = n.call(checker, scaled(n))
    return {"Fac": f, "Color": n.call(either, f, n.color("Color1", 0.8), n.color("Color2", 0.2))}


# ------------------------------------------------------------------ Brick


def brick_noise(number: NDArray[np.uint32]) -> Float32:
    """A random number in [0, 1) of an integer, as Cycles' bricks have it."""
    n = (number + np.uint32(1013)) & np.uint32(0x7FFFFFFF)
    n = (n >> np.uint32(13)) ^ n
    n = (n * (n * n * np.uint32(60493) + np.uint32(19990303)) + np.uint32(1376312589)) & np.uint32(0x7FFFFFFF)
    return np.float32(0.5) * (n.astype(np.float32) * np.float32(1 / 1073741824))


@op(FLOAT, FLOAT)
def brick(
    offset: float,
    offset_every: int,
    squash: float,
    squash_every: int,
    p: Float32,
    mortar: Float32,
    smooth: Float32,
    bias: Float32,
    width: Float32,
    height: Float32,
) -> tuple[Float32, Float32]:
    """Tint of the brick at p, and how much is mortar: no number where rows have no height, as in Cycles."""
    row = np.floor(divide(p[1], height)).astype(np.int32)
    shift: Float32 | float = 0.0
    if offset_every and squash_every:
        width = width * select(row % np.int32(squash_every) == 0, np.float32(squash), np.float32(1))
        shift = select(row % np.int32(offset_every) == 0, width * np.float32(offset), np.float32(0))
    along = p[0] + shift
    column = np.floor(divide(along, width)).astype(np.int32)
    x, y = along - width * column.astype(np.float32), p[1] - height * row.astype(np.float32)
    number = (row.astype(np.uint32) << np.uint32(16)) + (column.astype(np.uint32) & np.uint32(0xFFFF))
    tint = np.clip(brick_noise(number) + bias, 0, 1)
    across, upright = np.minimum(x, width - x), np.minimum(y, height - y)
    edge = select(width == 0, upright, np.minimum(across, upright))  # a row squashed to nothing has no ends
    edge = select(height == 0, np.float32(np.nan), edge)
    inside = edge >= mortar
    depth = 1 - divide(edge, mortar)
    hard = smooth == 0
    part = select(hard, np.float32(1), smooth_step(np.clip(divide(depth, smooth), 0, 1)))
    return tint, part * ~inside


@op(COLOR)
def brick_color(tint: Float32, mortar: Float32, one: Float32, other: Float32, between: Float32) -> Float32:
    """Two brick colours by tint, mortar between."""
    body = (1 - tint) * one + tint * other
    out: Float32 = body * (1 - mortar) + between * mortar
    return out


@node("TexBrick")
def tex_brick(n: NodeView) -> Outputs:
    static = (
        float(n.prop("offset", 0.5)),
        int(n.prop("offset_frequency", 2)),
        float(n.prop("squash", 1.0)),
        int(n.prop("squash_frequency", 2)),
    )
    sizes = [
        n.float("Mortar Size", 0.02),
        n.float("Mortar Smooth", 0.1),
        n.float("Bias"),
        n.float("Brick Width", 0.5),
        n.float("Row Height", 0.25),
    ]
    tint, mortar = n.calls(brick, scaled(n), *sizes, static=static)
    out: dict[str, Value | None] = {"Fac": mortar}
    if n.wants("Color"):
        colors = n.color("Color1", 0.8), n.color("Color2", 0.2), n.color("Mortar")
        out["Color"] = n.call(brick_color, tint, mortar, *colors)
    return out


# ------------------------------------------------------------------ Gradient


@op(FLOAT)
def gradient(kind: str, p: Float32) -> Float32:
    """The Gradient texture's value in [0, 1]."""
    x, y, z = p
    if kind == "LINEAR":
        f = x
    elif kind == "QUADRATIC":
        f = np.maximum(x, 0) ** 2
    elif kind == "EASING":
        f = smooth_step(np.clip(x, 0, 1))
    elif kind == "DIAGONAL":
        f = (x + y) * np.float32(0.5)
    elif kind == "RADIAL":
        f = np.arctan2(y, x) * np.float32(0.5 / np.pi) + np.float32(0.5)
    else:
        f = np.maximum(np.float32(0.999999) - np.sqrt(x * x + y * y + z * z), 0)
        f = f * f if kind == "QUADRATIC_SPHERE" else f
    out: Float32 = np.clip(f, 0, 1)
    return out


@node("TexGradient")
def tex_gradient(n: NodeView) -> Outputs:
    f = n.call(gradient, coordinates(n), static=(str(n.prop("gradient_type", "LINEAR")),))
    return {"Fac": f, "Color": n.call(spread_color, f)}


# ------------------------------------------------------------------ Magic


@op(COLOR)
def magic(depth: int, p: Float32, scale: Float32, distortion: Float32) -> Float32:
    """Psychedelic sines of sines."""
    px, py, pz = np.fmod(p * scale, np.float32(2 * np.pi))
    x = np.sin((px + py + pz) * 5)
    y = np.cos((-px + py - pz) * 5)
    z = -np.cos((-px - py + pz) * 5)
    d = distortion
    if depth > 0:
        x, y, z = x * d, y * d, z * d
        y = -np.cos(x - y + z) * d
    if depth > 1:
        x = np.cos(x - y - z) * d
    if depth > 2:
        z = np.sin(-x - y - z) * d
    if depth > 3:
        x = -np.cos(-x + y - z) * d
    if depth > 4:
        y = -np.sin(-x + y + z) * d
    if depth > 5:
        y = -np.cos(-x + y + z) * d
    if depth > 6:
        x = np.cos(x + y + z) * d
    if depth > 7:
        z = np.sin(x + y - z) * d
    if depth > 8:
        x = -np.cos(-x - y + z) * d
    if depth > 9:
        y = -np.sin(x - y + z) * d
    twice = 2 * d + (d == 0)
    return np.float32(0.5) - np.stack([x / twice, y / twice, z / twice])


@node("TexMagic")
def tex_magic(n: NodeView) -> Outputs:
    inputs = coordinates(n), n.float("Scale", 5.0), n.float("Distortion", 1.0)
    color = n.call(magic, *inputs, static=(int(n.prop("turbulence_depth", 2)),))
    # Fac is the mean of the components, not their luminance
    return {"Color": color, "Fac": n.call(mean, n.builder.convert(color, VECTOR))}


# ------------------------------------------------------------------ White Noise


@op(FLOAT)
def white_noise(*p: Float32) -> Float32:
    """A random number of 1 to 4 coordinates."""
    return hashes.floats_to_float(*p)


@op(COLOR)
def white_noise_color(*p: Float32) -> Float32:
    """A random colour of 1 to 4 coordinates."""
    return hashes.floats_to_color(*p)


@node("TexWhiteNoise")
def tex_white_noise(n: NodeView) -> Outputs:
    dimensions = int(str(n.prop("noise_dimensions", "3D"))[0])
    x, y, z = n.calls(separate, n.vector("Vector"))
    w = n.float("W")
    args = {1: (w,), 2: (x, y), 3: (x, y, z), 4: (x, y, z, w)}[dimensions]
    table = {"Value": white_noise, "Color": white_noise_color}
    return {name: n.call(what, *args) for name, what in table.items() if n.wants(name)}
