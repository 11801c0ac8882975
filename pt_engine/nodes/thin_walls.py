"""Thin walls: sheets without an inside, which light passes without being bent.

Between its two faces, each of reflectance r and transmittance t, light crosses the glass many times and each
time keeps the share c of its colour; in all

    T = c t₁ t₂/(1 − (r₂ c)²)        R = r₁ + T r₂ c        c = color^(1/cosθt)

where a film on the outside makes the faces differ as seen from without (1) and within (2). As in Cycles and
in OpenPBR's thin-walled case, T is scattered by `bsdfs.thin_transmission`, R by a reflection as rough as a
face.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import dielectric, interface
from ..bsdfs.microfacet import SMOOTH
from ..bsdfs.thin_transmission import sheet_alpha
from ..core.raykind import RayKind
from .energy_nodes import gained, glossy_cosine
from .graph import NodeView
from .ir import COLOR, FLOAT, Value, op
from .light_path import is_ray_kind
from .roughness import Rough
from .surface import SurfaceBuilder, is_zero

Float32 = NDArray[np.float32]


@op(FLOAT)
def is_true(x: Float32) -> Float32:
    """A number as a switch: 1 where its whole part is not 0."""
    out: Float32 = (np.trunc(x) != 0).astype(np.float32)
    return out


@op(FLOAT)
def smooth_sheet(alpha: Float32) -> Float32:
    """1 where the sheet bends nothing."""
    out: Float32 = (alpha * alpha <= SMOOTH).astype(np.float32)
    return out


@op(FLOAT)
def rough_sheet(alpha: Float32, ior: Float32) -> Float32:
    """`thin_transmission.sheet_alpha`."""
    return sheet_alpha(alpha, ior)


@op(COLOR, COLOR)
def sheet_shares(
    cos: Float32, ior: Float32, tint: Float32, color: Float32, *film: Float32
) -> tuple[Float32, Float32]:
    """What a sheet reflects and what it lets through, R and T above: (3, N) each.

    `tint` is of a face's reflectance at normal incidence; `film` its thickness and index.
    """
    outside = _face(ior, tint, film)(cos)
    g = outside.g
    r1, t1 = outside.reflected, outside.transmitted
    cos_t = np.maximum(g / ior, np.float32(1e-6))
    r2, t2 = r1, t1
    if film:
        inverse: Float32 = 1.0 / ior
        inside = _face(inverse, tint, (film[0], film[1] * inverse))(cos_t)
        r2, t2 = inside.reflected, inside.transmitted
    c = np.power(color, 1 / cos_t)
    again = r2 * c
    lost = 1 - again * again
    through: Float32 = np.where(lost > 0, c * t1 * t2 / np.maximum(lost, np.float32(1e-20)), 0)
    through = through.astype(np.float32, copy=False)
    return r1 + through * again, through


def _face(eta: Float32, tint: Float32, film: tuple[Float32, ...]) -> interface.Law:
    nothing = np.zeros(1, np.float32)
    return dielectric.law(dielectric.Params(nothing, eta, None, None, tint, *film))


def add_sheet(
    n: NodeView,
    out: SurfaceBuilder,
    weight: Value,
    alpha: Value,
    ior: Value,
    colors: tuple[Value, Value],
    film: Mapping[str, Value],
    normal: Value | None,
) -> None:
    """A thin sheet of glass; `colors`: the tint of its reflection, and what it lets through at right angles.

    A smooth one is transparent to all but the camera's rays, so that light finds its way through (as Cycles).
    """
    b, (tint, color) = n.builder, colors
    reflected, passed = n.calls(sheet_shares, glossy_cosine(n, normal), ior, tint, color, *film.values())
    rough = Rough(alpha)
    mirror = gained(n, b.multiply(weight, reflected), rough, tint, normal)
    out.add("conductor", rough.params(), mirror, normal, None, rough.is_smooth)
    through = Rough(n.call(rough_sheet, alpha, ior))
    passed = b.multiply(weight, passed)
    straight = b.multiply(n.call(smooth_sheet, through.alpha_x), b.complement(camera_rays(n)))
    if not is_zero(straight):
        out.add_transparent(b.multiply(passed, straight))
        passed = b.multiply(passed, b.complement(straight))
    passed = gained(n, passed, through, b.constant(1.0, COLOR), normal)
    out.add("thin_transmission", {"alpha": through.alpha_x}, passed, normal, None, through.is_smooth)


def camera_rays(n: NodeView) -> Value:
    """1 for rays from the camera."""
    return n.call(is_ray_kind, static=(RayKind.CAMERA,))


@op(FLOAT)
def forward(anisotropy: Float32) -> Float32:
    """The share of light in a sheet of dense matter that comes out on the far side: (1 + g)/2."""
    share: Float32 = np.clip(0.5 * (1 + anisotropy), 0, 1)
    return share
