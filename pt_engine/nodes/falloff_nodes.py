"""Light Falloff: how a lamp's strength is made to fall with distance."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .graph import NodeView
from .ir import FLOAT, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]
DISTANT: Final = np.float32(1e29)  # rays that are longer go to suns and to the sky


@node("LightFalloff")
def light_falloff(n: NodeView) -> Outputs:
    strength, smooth = n.float("Strength", 100.0), n.float("Smooth", 0.0)
    return {
        name: n.call(falloff, strength, smooth, static=(power,))
        for name, power in (("Quadratic", 0), ("Linear", 1), ("Constant", 2))
        if n.wants(name)
    }


@lane_op(FLOAT)
def falloff(lanes: Any, power: int, strength: Float32, smooth: Float32) -> Float32:
    """strength · dᵖ · d²/(smooth + d²), d the distance to the light; of distant lights the strength alone."""
    near = lanes.ray_length < DISTANT
    d = np.where(near, lanes.ray_length, np.float32(1))
    smooth = np.maximum(smooth, 0) * near
    out = strength * (d**power if power else 1)
    return out * (d * d / (smooth + d * d + (d == 0)))  # type: ignore[no-any-return]
