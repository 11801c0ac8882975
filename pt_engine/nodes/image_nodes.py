"""Image and environment textures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..textures import environment
from ..textures.images import ImageError, Texture
from ..textures.texture import MISSING
from .coordinates import coordinates, object_space_normal, position, uv_coordinates
from .graph import NodeView
from .ir import COLOR, FLOAT, Value, op
from .math_nodes import select
from .registry import Outputs, node
from .vector_nodes import unit

Float32 = NDArray[np.float32]


@op(COLOR, FLOAT, dear=True)
def image_flat(texture: Texture, at: Float32) -> tuple[Float32, Float32]:
    """An image at (x, y) of the vector."""
    return texture.sample(at[0], at[1])


@op(COLOR, FLOAT, dear=True)
def image_sphere(texture: Texture, at: Float32) -> tuple[Float32, Float32]:
    """An image wrapped around the unit box's inscribed sphere."""
    x, y, z = at * 2 - 1
    size = np.sqrt(x * x + y * y + z * z)
    some = size > 0
    u = 0.5 - np.arctan2(x, y) * np.float32(0.5 / np.pi)
    u = select((x == 0) & (y == 0), np.float32(0), u)
    v = 1 - np.arccos(np.clip(z / (size + ~some), -1, 1)) * np.float32(1 / np.pi)
    return texture.sample(u * some, v * some)


@op(COLOR, FLOAT, dear=True)
def image_tube(texture: Texture, at: Float32) -> tuple[Float32, Float32]:
    """An image wrapped around the unit box's inscribed cylinder."""
    x, y, z = at * 2 - 1
    some = (x != 0) | (y != 0)
    u = (1 - np.arctan2(x, y) * np.float32(1 / np.pi)) * np.float32(0.5)
    return texture.sample(u * some, (z + 1) * np.float32(0.5) * some)


@op(COLOR, FLOAT, dear=True)
def image_box(texture: Texture, blend: float, at: Float32, normal: Float32) -> tuple[Float32, Float32]:
    """An image on the three axes' planes, blended by the normal."""
    weights = box_weights(normal, blend)
    x, y, z = at
    sides = (
        (select(normal[0] < 0, 1 - y, y), z),
        (select(normal[1] > 0, 1 - x, x), z),
        (select(normal[2] > 0, 1 - y, y), x),
    )
    size = max(at.shape[-1], normal.shape[-1])
    color, alpha = np.zeros((3, size), np.float32), np.zeros(size, np.float32)
    for weight, (u, v) in zip(weights, sides, strict=True):
        some = np.flatnonzero(np.broadcast_to(weight > 0, size))
        if len(some) == 0:
            continue
        c, a = texture.sample(*(np.broadcast_to(w, size).take(some) for w in (u, v)))
        share = np.broadcast_to(weight, size).take(some)
        for total, value in zip((*color, alpha), (*c, a), strict=True):
            total[some] += share * value
    return color, alpha


def box_weights(normal: Float32, blend: float) -> Float32:
    """(3, n) share of each axis' image: one in the corners, two or three where they blend.

    The absolute normal, scaled to sum 1, is a point in a triangle whose corners are the axes; `blend`
    widens the zones where two or three images mix (Cycles' seven zones).
    """
    n = np.abs(normal)
    n = n / np.maximum(n[0] + n[1] + n[2], np.float32(1e-20))
    limit = 0.5 * (1 + blend)
    out: Float32 = np.zeros_like(n)
    free = np.ones(n.shape[1], np.float32)  # 1 until a zone is found; floats, which numpy mixes faster
    for a, b, c in ((0, 1, 2), (1, 0, 2), (2, 0, 1)):
        alone = (n[a] > limit * (n[a] + n[b])) & (n[a] > limit * (n[a] + n[c]))
        out[a] = alone.astype(np.float32) * free
        free -= out[a]
    if blend <= 0:
        out[0] += free
        return out
    for a, b, c in ((0, 1, 2), (1, 2, 0), (0, 2, 1)):
        pair = n[a] + n[b]
        two = (n[c] < (1 - limit) * pair).astype(np.float32) * free
        share = n[a] / np.maximum(pair, np.float32(1e-20))
        share = two * np.clip((share - 0.5 * (1 - blend)) / blend, 0, 1)
        out[a] += share
        out[b] += two - share
        free -= two
    out += free * (((2 - limit) * n + np.float32(limit - 1)) / np.float32(2 * limit - 1))
    return out


PROJECTIONS = {"FLAT": image_flat, "SPHERE": image_sphere, "TUBE": image_tube}


def missing(n: NodeView, problem: str) -> Outputs:
    """Blender's magenta; where a node has no image at all that is what it says."""
    if n.node.props.get("image") is None:
        n.exact(f"{problem}: magenta, as in Cycles")
    else:
        n.ignored(f"{problem}: magenta")
    return {"Color": n.constant(MISSING, COLOR), "Alpha": n.constant(1.0, FLOAT)}


def texture_of(n: NodeView, extension: str, first_tile: bool = False) -> Texture:
    """The node's image with its filter; what is wrong with it is listed."""
    index = n.node.props.get("image")
    if not isinstance(index, int) or isinstance(index, bool):
        raise ImageError("no image is set")
    interpolation = str(n.prop("interpolation", "Linear"))
    texture = n.reader.textures.texture(index, interpolation, extension, n.wants("Alpha"), first_tile)
    for note in texture.notes:
        n.ignored(note)
    return texture


@node("TexImage")
def tex_image(n: NodeView) -> Outputs:
    projection = str(n.prop("projection", "FLAT"))
    try:
        # a box's six sides are the unit square, so Cycles loads no tile but the first
        texture = texture_of(n, str(n.prop("extension", "REPEAT")), first_tile=projection == "BOX")
    except ImageError as problem:
        return missing(n, str(problem))
    at = coordinates(n, uv_coordinates, ("",))
    if projection == "BOX":
        static: tuple[Any, ...] = (texture, float(n.prop("projection_blend", 0.0)))
        color, alpha = n.calls(image_box, at, n.call(object_space_normal, *n.bent()), static=static)
    else:
        color, alpha = n.calls(PROJECTIONS.get(projection, image_flat), at, static=(texture,))
    return {"Color": color, "Alpha": alpha}


@op(COLOR, FLOAT, dear=True)
def environment_map(texture: Texture, projection: str, direction: Float32) -> tuple[Float32, Float32]:
    """An environment map in a direction; in none at all its corner, as in Cycles."""
    if projection == "MIRROR_BALL":
        return texture.sample(*environment.mirror_ball_uv(unit(direction)))
    u, v = environment.equirectangular_uv(unit(direction))
    some = (direction != 0).any(axis=0)
    return texture.sample(u * some, v * some)


@node("TexEnvironment")
def tex_environment(n: NodeView) -> Outputs:
    try:
        texture = texture_of(n, "REPEAT")
    except ImageError as problem:
        return missing(n, str(problem))
    at: Value = coordinates(n, position)
    color, alpha = n.calls(
        environment_map, at, static=(texture, str(n.prop("projection", "EQUIRECTANGULAR")))
    )
    return {"Color": color, "Alpha": alpha}
