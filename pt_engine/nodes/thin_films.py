"""A thin film's inputs as parameters of a scattering model: none at all where it is constantly too thin."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.thin_film import THINNEST
from .graph import NodeView
from .ir import FLOAT, Value, lane_op
from .math_nodes import at_least
from .surface import is_at_most

Float32 = NDArray[np.float32]


@lane_op(FLOAT)
def index_from_here(lanes: Any, film_ior: Float32, ior: Float32) -> Float32:
    """The film's index over that of the viewer's side, which behind the face is the material's."""
    out: Float32 = film_ior * (1 + lanes.backfacing * (1 / np.maximum(ior, np.float32(1e-5)) - 1))
    return out


def film_params(n: NodeView) -> dict[str, Value]:
    """The film on an opaque surface."""
    thickness = n.float("Thin Film Thickness")
    if is_at_most(thickness, THINNEST):
        return {}
    ior = n.call(at_least, n.float("Thin Film IOR", 1.33), n.constant(1e-5, FLOAT))
    return {"film_thickness": thickness, "film_ior": ior}


def glass_film_params(n: NodeView, ior: Value) -> dict[str, Value]:
    """The film on glass of index `ior`: from within, glass lies before it and air beyond."""
    film = film_params(n)
    if film:
        film["film_ior"] = n.call(index_from_here, film["film_ior"], ior)
    return film
