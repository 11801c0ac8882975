"""Shader nodes for hair: the Hair BSDF with one lobe, and Principled Hair (Huang's model: `hair_huang`).

They ask the lanes for the hair's direction and for where across it the ray has hit. On meshes triangles
stand in for hair as in Cycles: their edges for its direction, their normal for the offset h.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import hair_chiang
from ..core import vectors
from .geometry_nodes import true_normal
from .graph import NodeView
from .hair_huang import add_huang
from .ir import COLOR, FLOAT, VECTOR, Value, lane_op, op
from .math_nodes import saturate
from .registry import shader
from .round_nodes import on_strand
from .surface import SurfaceBuilder, is_zero

Float32 = NDArray[np.float32]
EUMELANIN: Final = np.array([0.506, 0.841, 1.653], np.float32)[:, np.newaxis]
PHEOMELANIN: Final = np.array([0.343, 0.733, 1.924], np.float32)[:, np.newaxis]

IN_CYCLES: Final = "on meshes Cycles drops light of some lamps, as if the normal were bumped; here not"
LONG_INSIDE: Final = "; as Cycles' sampler has it, which toward lamps lacks light that stays inside for long"


# ------------------------------------------------------------------ where the hair lies


@lane_op(VECTOR, reads="position")
def along_hair(lanes: Any, corner: int) -> Float32:
    """Unit vector toward a strand's tip, or from a triangle's corner 0 to its corner 1 or 2."""
    return lanes.along_hair(corner)  # type: ignore[no-any-return]


@lane_op(FLOAT)
def lean(lanes: Any, tangent: Float32) -> Float32:
    """Cosine between the tangent and the shading normal."""
    return vectors.dot(tangent, lanes.ns)


@lane_op(FLOAT)
def offset_across(lanes: Any, tangent: Float32) -> Float32:
    """h: minus the normal's part along tangent × wi."""
    h: Float32 = -vectors.dot(lanes.ng, vectors.normalize(vectors.cross(tangent, lanes.wi)))
    return h


@op(VECTOR)
def unit(v: Float32) -> Float32:
    """v / |v|."""
    return vectors.normalize(v)


@op(FLOAT)
def minus(x: Float32) -> Float32:
    """−x."""
    return -x


# ------------------------------------------------------------------ the Hair BSDF


@shader("BsdfHair")
def hair(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    """One lobe. Without a Tangent, only strands' own is tilted, as in Cycles."""
    weight = n.builder.multiply(weight, n.color("Color", 0.8))
    if is_zero(weight):
        return
    n.approximate("as its formula has it; under a sky Cycles' sampler adds light that its evaluation lacks")
    linked = n.optional("Tangent")
    tangent = n.call(along_hair, static=(2,)) if linked is None else n.call(unit, linked)
    tilted = n.call(on_strand) if linked is None else n.builder.one
    params = {
        "roughness_u": n.float("RoughnessU", 0.1),
        "roughness_v": n.float("RoughnessV", 1.0),
        "offset": n.builder.multiply(n.call(minus, n.float("Offset")), tilted),
        "lean": n.call(lean, tangent),
    }
    transmits = str(n.prop("component", "Reflection")).upper() == "TRANSMISSION"
    out.add("hair_transmission" if transmits else "hair_reflection", params, weight, None, tangent)


# ------------------------------------------------------------------ Principled Hair


@op(FLOAT)
def varied(value: Float32, random: Float32, amount: Float32) -> Float32:
    """A value times 1 ± amount, as a random number in [0, 1] has it."""
    out: Float32 = value * (1 + 2 * (random - np.float32(0.5)) * amount)
    return out


@op(COLOR)
def pigments(melanin: Float32, redness: Float32) -> Float32:
    """Absorption of melanin, of which `redness` is pheomelanin; a share in [0, 1] stands for any amount."""
    amount = -np.log(np.maximum(1 - melanin, np.float32(1e-4)))
    out: Float32 = amount * (1 - redness) * EUMELANIN + amount * redness * PHEOMELANIN
    return out


@op(COLOR)
def absorption(color: Float32, around: Float32) -> Float32:
    """The absorption with which hair of an azimuthal roughness has a colour in all: Chiang's fit."""
    x = around
    scale = ((((0.245 * x + 5.574) * x - 10.73) * x + 2.532) * x - 0.215) * x + 5.969
    root = np.log(np.maximum(color, np.float32(1e-30))) / scale
    out: Float32 = root * root
    return out


@op(FLOAT)
def first_roughness(roughness: Float32, coat: Float32) -> Float32:
    """That of the first reflection, which a coat makes smoother."""
    out: Float32 = np.clip(roughness, np.float32(1e-3), 1) * (1 - np.clip(coat, 0, 1))
    return out


@op(FLOAT)
def variance(roughness: Float32) -> Float32:
    """`hair_chiang.variance`."""
    return hair_chiang.variance(roughness)


@op(FLOAT)
def logistic_scale(roughness: Float32) -> Float32:
    """`hair_chiang.scale`."""
    return hair_chiang.scale(roughness)


@lane_op(FLOAT, reads="strand")
def own_random(lanes: Any, otherwise: Float32) -> Float32:
    """A strand's random number."""
    out = np.zeros(lanes.n, np.float32) + otherwise
    if lanes.rounds is not None:
        where = lanes.rounds.curves
        out[where] = lanes.strand()[2].take(where)
    return out


@shader("BsdfHairPrincipled")
def principled_hair(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    """Chiang's model or Huang's."""
    huang = n.prop("model", "CHIANG") == "HUANG"
    n.approximate(IN_CYCLES + (LONG_INSIDE if huang else ""))
    random, spread = randomness(n), n.float("Random Roughness")
    rough = n.call(varied, n.float("Roughness", 0.3), random, spread)
    around = rough if huang else n.call(varied, n.float("Radial Roughness", 0.3), random, spread)
    tangent = n.call(along_hair, static=(1,))
    h, sigma = n.call(offset_across, tangent), coloring(n, random, around)
    if huang:
        add_huang(n, weight, out, sigma, rough, h, tangent)
        return
    params = {
        "v": n.call(variance, rough),
        "v0": n.call(variance, n.call(first_roughness, rough, n.float("Coat"))),
        "s": n.call(logistic_scale, around),
        "alpha": n.call(minus, n.float("Offset", np.radians(2.0))),
        "eta": n.float("IOR", 1.55),
        "sigma": sigma,
        "h": h,
    }
    out.add("hair_chiang", params, weight, n.call(true_normal), tangent)


def randomness(n: NodeView) -> Value:
    """The Random input; unlinked, strands have their own number."""
    given = n.float("Random")
    unused = is_zero(n.float("Random Roughness")) and is_zero(n.float("Random Color"))
    return given if unused or n.linked("Random") is not None else n.call(own_random, given)


def coloring(n: NodeView, random: Value, around: Value) -> Value:
    """Absorption, by whichever way the node describes it."""
    way = n.prop("parametrization", "COLOR")
    if way == "ABSORPTION":
        return n.builder.convert(n.vector("Absorption Coefficient", (0.245531, 0.52, 1.365)), COLOR)
    if way == "COLOR":
        return n.call(absorption, n.color("Color", (0.017513, 0.005763, 0.002059)), around)
    melanin = n.call(varied, n.float("Melanin", 0.8), random, n.call(saturate, n.float("Random Color")))
    tint = n.call(absorption, n.color("Tint", 1.0), around)
    return n.builder.add(n.call(pigments, melanin, n.float("Melanin Redness", 1.0)), tint)
