"""IES Texture: the strength of a luminaire in the direction that its light goes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..textures.ies import UNREADABLE, Luminaire, luminaire
from .graph import NodeView
from .ir import FLOAT, VECTOR, lane_op, op
from .registry import Outputs, node
from .vector_nodes import unit

Float32 = NDArray[np.float32]


@lane_op(VECTOR)
def object_incoming(lanes: Any) -> Float32:
    """Toward the viewer, in object space, as normals are transformed."""
    to_object = getattr(lanes, "to_object_normal", None)
    return lanes.wi if to_object is None else to_object(lanes.wi)  # type: ignore[no-any-return]


@op(FLOAT)
def strength(lamp: Luminaire, direction: Float32) -> Float32:
    """Of a luminaire that hangs upright: −Z is straight down."""
    d = unit(direction)
    down = np.arccos(np.clip(-d[2], np.float32(-1), np.float32(1)))
    return lamp.strength(np.arctan2(d[0], d[1]) + np.float32(np.pi), down)


@node("TexIES")
def tex_ies(n: NodeView) -> Outputs:
    lamp = luminaire(str(n.prop("ies_text", "")))
    amount = n.float("Strength", 1.0)
    if lamp is None:
        n.ignored("the IES file is missing or is none: 100 in all directions, as in Cycles")
        return {"Fac": n.builder.multiply(amount, n.constant(UNREADABLE, FLOAT))}
    given = n.optional("Vector")
    direction = n.call(object_incoming) if given is None else given
    return {"Fac": n.builder.multiply(amount, n.call(strength, direction, static=(lamp,)))}
