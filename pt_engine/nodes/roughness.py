"""From Blender's roughness, anisotropy and rotation to what the scattering models take."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import microfacet
from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, VECTOR, Const, Value, lane_op, op
from .math_nodes import select
from .surface import is_at_most, is_zero
from .tangents import surface_tangent

Float32 = NDArray[np.float32]
TWO_PI: Final = np.float32(2 * np.pi)


class Rough(NamedTuple):
    """Roughness along tangent and bitangent (`alpha_y` None: isotropic), and the tangent (None: any)."""

    alpha_x: Value
    alpha_y: Value | None = None
    tangent: Value | None = None

    def params(self) -> dict[str, Value]:
        """As parameters of a microfacet model."""
        return {"alpha_x": self.alpha_x} | ({} if self.alpha_y is None else {"alpha_y": self.alpha_y})

    def is_at_most(self, alpha: float) -> bool:
        """Whether it is constantly no rougher than `alpha`, either way."""
        alphas = (self.alpha_x, self.alpha_x if self.alpha_y is None else self.alpha_y)
        return all(is_at_most(value, alpha) for value in alphas)

    @property
    def is_smooth(self) -> bool:
        """Whether it is constantly an ideal mirror."""
        ys = self.alpha_x if self.alpha_y is None else self.alpha_y
        if not (isinstance(self.alpha_x, Const) and isinstance(ys, Const)):
            return False
        return bool((self.alpha_x.data * ys.data <= microfacet.SMOOTH).all())


@op(FLOAT)
def squared(roughness: Float32) -> Float32:
    """α = roughness², roughness clamped to [0, 1]."""
    r = np.minimum(np.maximum(roughness, 0), 1)
    return r * r


@op(FLOAT, FLOAT)
def glossy_alphas(roughness: Float32, anisotropy: Float32) -> tuple[Float32, Float32]:
    """The Glossy node's: α(1 − a) and α/(1 − a) for a ≥ 0, α/(1 + a) and α(1 + a) below."""
    alpha = np.clip(roughness, 0, 1) ** 2
    a = np.clip(anisotropy, -0.99, 0.99)
    near = 1 - np.abs(a)
    positive = a >= 0
    wide = np.minimum(alpha / near, 1)
    return select(positive, alpha * near, wide), select(positive, wide, alpha * near)


@op(FLOAT, FLOAT)
def principled_alphas(roughness: Float32, anisotropic: Float32) -> tuple[Float32, Float32]:
    """Principled's and Metallic's: α/s and α·s, s = √(1 − 0.9 a)."""
    alpha: Float32 = np.clip(roughness, 0, 1) ** 2
    aspect: Float32 = np.sqrt(1 - np.clip(anisotropic, 0, 1) * np.float32(0.9))
    return np.minimum(alpha / aspect, 1), alpha * aspect


@lane_op(VECTOR)
def turned_tangent(lanes: Any, tangent: Float32, rotation: Float32, *normal: Float32) -> Float32:
    """The tangent turned about the normal by `rotation` full turns."""
    n = normal[0] if normal else lanes.ns
    angle = rotation * TWO_PI
    cos, sin = np.cos(angle), np.sin(angle)
    out: Float32 = tangent * cos + vectors.cross(n, tangent) * sin + n * (vectors.dot(n, tangent) * (1 - cos))
    return out


def isotropic(n: NodeView, default: float = 0.5, name: str = "Roughness") -> Rough:
    """Roughness without a direction."""
    return Rough(n.call(squared, n.float(name, default)))


def anisotropic(n: NodeView, alphas: Any, names: tuple[str, str], normal: Value | None) -> Rough:
    """Roughness with a direction, where the node's anisotropy is not constantly 0."""
    anisotropy = n.float(names[0])
    if is_zero(anisotropy):
        return isotropic(n)
    alpha_x, alpha_y = n.calls(alphas, n.float("Roughness", 0.5), anisotropy)
    linked = n.optional("Tangent")
    tangent = n.call(surface_tangent, *n.bent()) if linked is None else linked
    rotation = n.float(names[1])
    if not is_zero(rotation):
        extra = () if normal is None else (normal,)
        tangent = n.call(turned_tangent, tangent, rotation, *extra)
    return Rough(alpha_x, alpha_y, tangent)
