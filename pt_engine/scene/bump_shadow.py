"""How diffuse light fades where a bumped normal leans away from the smooth one.

Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator
Problem": the bumps count as microfacets of roughness α² = tan²δ/8, δ the angle between the normals, and
light at θ to the smooth normal is shadowed as by GGX,

    G₁ = 2 / (1 + √(1 + α² tan²θ))

and what the smooth normal has on the other side than the bumped one gets nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot

Float32 = NDArray[np.float32]
TINY = np.float32(1e-6)


def bump_shadow(smooth: Float32, bumped: Float32, wo: Float32) -> Float32:
    """(N,) factor on a diffuse closure about `bumped` toward `wo`; 1 where both normals are the same."""
    cos_o, cos_d = dot(smooth, wo), dot(smooth, bumped)
    lit = cos_o * cos_d * dot(bumped, wo) >= 0
    cos2_o, cos2_d = (np.minimum(np.maximum(c * c, TINY * TINY), 1) for c in (cos_o, cos_d))
    alpha2 = np.minimum(np.float32(0.125) * (1 / cos2_d - 1), 1)
    shadow: Float32 = lit * (2 / (1 + np.sqrt(1 + alpha2 * (1 / cos2_o - 1))))
    return shadow
