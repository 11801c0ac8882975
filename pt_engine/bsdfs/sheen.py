"""Sheen: light scattered by fibres that stand on a surface, brightest toward the rim.

    f·cosθo = R/π z (a/l²)²,   l² = (a x + b z)² + (a y)² + z²         pdf = f·cosθo / R,   weight = R

Zeltner, Burley and Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines": a
cosine lobe bent by a matrix, (x, y, z) = wo in the frame whose x axis is the viewer's side. a, b and the
albedo R depend on roughness and θi; the tables of `sheen.npz` are Cycles', as `tools/measure_sheen.py`
has measured them. R is what the layers below do without.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..core import warps
from .base import BSDFSample, Float32, Lobe
from .interpolation import plane

LEAST = 1e-5  # albedos and lobes below this are left out, as in Cycles
LEAST_ROUGHNESS = 1e-3
INV_PI = float(warps.INV_PI)


class Params(NamedTuple):
    """
    Attributes
    ----------
    roughness : (N,) float32 in [0, 1]
    """

    roughness: Float32


class Lobes(NamedTuple):
    """a, b and R of the lanes, (N,) each; a = 1 where R = 0."""

    a: Float32
    b: Float32
    albedo: Float32


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,), 0 below the surface."""
    lobes = _lobes(params.roughness, wi[2])
    pdf = _density(lobes, wi, wo)
    return (lobes.albedo * pdf)[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw from the cosine lobe and bend it."""
    lobes = _lobes(params.roughness, wi[2])
    x, y, z = warps.square_to_cosine_hemisphere(u1, u2)
    bent = np.stack([x - z * lobes.b, y, z * lobes.a])
    bent *= 1.0 / np.sqrt(bent[0] * bent[0] + bent[1] * bent[1] + bent[2] * bent[2])
    c, s = _azimuth(wi)
    wo = np.stack([c * bent[0] - s * bent[1], s * bent[0] + c * bent[1], bent[2]])
    weight = np.broadcast_to(lobes.albedo, u1.shape)[np.newaxis]
    return BSDFSample(wo, _density(lobes, wi, wo), weight, Lobe.DIFFUSE)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """R: (N,)."""
    return _lobes(params.roughness, cos_i).albedo


@cache
def _tables() -> tuple[Float32, Float32, Float32]:
    """a, b, R, of [roughness, cosθi]."""
    with np.load(Path(__file__).with_name("sheen.npz"), allow_pickle=False) as file:
        return file["a"], file["b"], file["albedo"]


def _lobes(roughness: Float32, cos_i: Float32) -> Lobes:
    rough = np.maximum(roughness, np.float32(LEAST_ROUGHNESS))
    a, b, albedo = (plane(table, rough, cos_i) for table in _tables())
    there = (a >= LEAST) & (albedo >= LEAST)
    return Lobes(1.0 + (a - 1.0) * there, b * there, albedo * there)


def _density(lobes: Lobes, wi: Float32, wo: Float32) -> Float32:
    c, s = _azimuth(wi)
    x, y, z = c * wo[0] + s * wo[1], c * wo[1] - s * wo[0], wo[2]
    along, across = lobes.a * x + lobes.b * z, lobes.a * y
    q = lobes.a / (along * along + across * across + z * z)
    pdf: Float32 = np.maximum(z, 0.0) * (lobes.albedo > 0) * INV_PI * q * q
    return pdf


def _azimuth(wi: Float32) -> tuple[Float32, Float32]:
    """Cosine and sine of the viewer's azimuth; 1 and 0 from straight above."""
    sine = np.sqrt(wi[0] * wi[0] + wi[1] * wi[1])
    above = (sine <= 1e-12).astype(wi.dtype)
    inverse = 1.0 / (sine + above)
    return wi[0] * inverse + above, wi[1] * inverse
