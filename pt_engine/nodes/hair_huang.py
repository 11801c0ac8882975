"""Principled Hair after Huang: what its closure is given beside the colour and roughness (`hair`).

The model is drawn anew at each point that is shaded: its random numbers are the path's (`core.keyed`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import keyed, vectors
from ..core.hashing import to_unit_interval
from ..core.raykind import RayKind
from .geometry_nodes import true_normal
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, lane_op, op
from .round_nodes import on_strand
from .surface import SurfaceBuilder, is_constantly

Float32 = NDArray[np.float32]
WHOLE = 4.0  # beyond any radius


@lane_op(VECTOR, VECTOR, FLOAT, reads="random numbers")
def ways(lanes: Any, key: int) -> tuple[Float32, Float32, Float32]:
    """Seven uniforms, 0.5 where there are none."""
    u = np.full((8, lanes.n), 0.5, np.float32)
    noise = getattr(lanes, "noise", None)
    if noise is not None:
        for pair in range(4):
            for row, bits in enumerate(keyed.bits(noise, key, pair)):
                to_unit_interval(bits, u[2 * pair + row])
    return u[:3], u[3:6], u[6]


@lane_op(FLOAT, reads="strand normal")
def azimuth(lanes: Any, tangent: Float32) -> Float32:
    """φ of wi about the strand, from its normal's cross product with it toward the normal; 0 on meshes."""
    out = np.zeros(lanes.n, np.float32)
    if lanes.rounds is not None:
        where = lanes.rounds.curves
        along, wi = tangent.take(where, axis=1), lanes.wi.take(where, axis=1)
        x = lanes.strand_normal(along)
        out[where] = np.arctan2(vectors.dot(wi, x), vectors.dot(wi, vectors.cross(x, along)))
    return out


@lane_op(FLOAT, reads=lambda: ("strand", "footprint", "ray_kind"))
def pixel_blur(lanes: Any) -> Float32:
    """Half a pixel over the radius of the strands that the camera sees; else all of the hair."""
    out = np.full(lanes.n, WHOLE, np.float32)
    if lanes.rounds is not None:
        where = lanes.rounds.curves[(lanes.ray_kind.take(lanes.rounds.curves) & RayKind.CAMERA) != 0]
        thickness = np.broadcast_to(lanes.strand()[3], lanes.n).take(where)
        width = np.broadcast_to(lanes.footprint, lanes.n).take(where)
        out[where] = np.minimum(width / np.maximum(thickness, 1e-30), WHOLE)
    return out


@op(FLOAT)
def shorter(aspect: Float32, strand: Float32) -> Float32:
    """The axes' ratio, on strands the shorter over the longer."""
    ratio = np.maximum(aspect, np.float32(1e-3))
    turned: Float32 = np.where((strand > 0) & (ratio > 1), 1 / ratio, ratio).astype(np.float32)
    return turned


@op(FLOAT)
def beside(h: Float32, phi: Float32, b: Float32) -> Float32:
    """1 where a ray that hits the round hair passes the flat one."""
    c, s = np.cos(phi), b * np.sin(phi)
    missed: Float32 = (h * h >= c * c + s * s).astype(np.float32)
    return missed


@op(VECTOR)
def strengths(*lobes: Float32) -> Float32:
    """Factors on the lobes, none of them negative."""
    out: Float32 = np.maximum(np.stack(np.broadcast_arrays(*lobes)), 0)
    return out


def add_huang(
    n: NodeView, weight: Value, out: SurfaceBuilder, sigma: Value, rough: Value, h: Value, tangent: Value
) -> None:
    """The closure; and a transparent one, where hair is flatter than what rays meet."""
    build, round_ = n.builder, n.builder.one
    aspect = n.float("Aspect Ratio", 0.85)
    enters, inside, last = n.calls(ways, static=(n.number,))
    phi: Value = build.zero
    if is_constantly(aspect, 1):
        b: Value = round_
    else:
        strand = n.call(on_strand)
        phi, b = n.call(azimuth, tangent), n.call(shorter, aspect, strand)
        missed = build.multiply(n.call(beside, h, phi, b), strand)
        out.add_transparent(build.convert(build.multiply(weight, missed), COLOR))
        weight = build.multiply(weight, build.complement(missed))
    params = {
        "alpha": rough,
        "tilt": build.multiply(n.constant(-1.0, FLOAT), n.float("Offset", np.radians(2.0))),
        "eta": n.float("IOR", 1.55),
        "sigma": sigma,
        "enters": enters,
        "inside": inside,
        "last": last,
        "aspect": b,
        "phi": phi,
        "h": h,
        "blur": n.call(pixel_blur),
    }
    lobes = [n.float(f"{name} lobe", 1.0) for name in ("R", "TT", "TRT")]
    if not all(is_constantly(lobe, 1) for lobe in lobes):
        params["strength"] = n.call(strengths, *lobes)
    out.add("hair_huang", params, weight, n.call(true_normal), tangent)
