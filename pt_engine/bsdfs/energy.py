"""Light that bounces between facets, and how much a rough gloss reflects in all: tables, interpolated.

A single-scattering model loses what hits a second facet: white facets reflect E(cosθ) < 1. Kulla and Conty
2017 ("Revisiting Physically Based Shading at Imageworks") give it back with the colour of repeated
reflection; as in Cycles it goes onto the single-scattering lobe as a factor,

    gain = 1 + Fms (1 − E)/E        Fms = F̄ Ē/(1 − F̄ (1 − Ē))

F̄ being the facets' reflectance and Ē that of the surface, averaged over the hemisphere. The factor depends
on wi alone, so it belongs in the closure's weight. It is not reciprocal, as in Cycles.

`make_tables` made the tables, and says what each holds.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .base import Float32
from .fresnel import dielectric
from .interpolation import cell, lerp, line, plane

Int32 = NDArray[np.int32]


def reflection_gain(alpha_x: Float32, alpha_y: Float32 | None, cos_i: Float32, average: Float32) -> Float32:
    """Factor for the weight of a GGX reflection.

    Parameters
    ----------
    alpha_x, alpha_y : (N,) or (1,) float32
    cos_i : (N,) float32
    average : (3, N), (3, 1) or (1, 1) float32
        Hemispherical average of the facets' reflectance (e.g. `conductor.average`).

    Returns
    -------
    (3, N) or (1, N) float32, ≥ 1
    """
    return gain_over(reflection_albedo(alpha_x, alpha_y, cos_i), alpha_x, alpha_y, average)


def gain_over(albedo: Float32, alpha_x: Float32, alpha_y: Float32 | None, average: Float32) -> Float32:
    """The same where `reflection_albedo` is known."""
    return _gain(albedo, line(_tables()["reflection_average"], table_roughness(alpha_x, alpha_y)), average)


def reflection_albedo(alpha_x: Float32, alpha_y: Float32 | None, cos_i: Float32) -> Float32:
    """E(cosθ) of white facets: (N,)."""
    return plane(_tables()["reflection"], table_roughness(alpha_x, alpha_y), cos_i)


def glass_gain(alpha: Float32, eta: Float32, cos_i: Float32, average: Float32) -> Float32:
    """Factor for the weight of GGX glass; `average` is its transmission's colour (as Cycles)."""
    rough = table_roughness(alpha, None)
    inside: Int32 = (eta < 1.0).astype(np.int32)
    albedo = glass_albedo(alpha, eta, cos_i)
    return _gain(albedo, _row2("glass_average", rough, _index_axis(eta), inside), average)


def glass_albedo(alpha: Float32, eta: Float32, cos_i: Float32) -> Float32:
    """E(cosθ) of clear GGX glass, reflection and refraction together: (N,)."""
    inside: Int32 = (eta < 1.0).astype(np.int32)
    return _lookup3("glass", table_roughness(alpha, None), _index_axis(eta), inside, cos_i)


def gloss(alpha_x: Float32, alpha_y: Float32 | None, eta: Float32, cos_i: Float32) -> Float32:
    """s of a rough dielectric's reflectance F0 + (1 − F0) s toward the viewer: (N,)."""
    nowhere = np.zeros(1, np.int32)
    return _lookup3("gloss", table_roughness(alpha_x, alpha_y), _index_axis(eta), nowhere, cos_i)


def passed(alpha: Float32, eta: Float32, cos: Float32) -> Float32:
    """Share of the light at cosθ that enters a dielectric, η > 1: (N,).

    The table's smooth end is replaced by Fresnel's own 1 − F: towards grazing that falls to 0 within less
    than a cell where η is near 1, and with a reflection of F the sum would be more than 1.
    """
    rough, z, nowhere = table_roughness(alpha, None), _index_axis(eta), np.zeros(1, np.int32)
    table: Float32 = _lookup3("passed", rough, z, nowhere, cos)
    share: Float32 = np.maximum(1.0 - rough * (len(_tables()["passed"]) - 1), 0.0)
    smooth = 1.0 - dielectric(np.maximum(cos, 0.0), eta)[0]
    return table + share * (smooth - _lookup3("passed", 0.0 * rough, z, nowhere, cos))


def inner_reflectance(alpha: Float32, eta: Float32) -> Float32:
    """Share of diffuse light inside a dielectric (η > 1) that its surface sends back: (N,) or (1,).

    By reciprocity what gets out is 1/η² of what gets in, 2∫ `passed` cosθ d(cosθ), and R the rest but for
    what is lost between facets. Interpolating the loss, not R, keeps a smooth surface from losing any.
    """
    rough, z, nowhere = table_roughness(alpha, None), _index_axis(eta), np.zeros(1, np.int32)
    out: Float32 = _row2("passed_average", rough, z, nowhere) / (eta * eta)
    back: Float32 = 1.0 - out - _row2("inner_loss", rough, z, nowhere)
    return back


def table_roughness(alpha_x: Float32, alpha_y: Float32 | None) -> Float32:
    """(αx αy)^¼, the tables' first axis."""
    root: Float32 = np.sqrt(alpha_x) if alpha_y is None else np.sqrt(np.sqrt(alpha_x * alpha_y))
    return root


def _gain(albedo: Float32, albedo_average: Float32, average: Float32) -> Float32:
    floor: Float32 = np.maximum(albedo, 1e-3)
    missing: Float32 = (1.0 - albedo) / floor
    average = np.minimum(average, 1.0)
    lost: Float32 = 1.0 - albedo_average
    multiple: Float32 = average * albedo_average
    multiple = multiple / (1.0 - average * lost)
    return 1.0 + multiple * missing


def _index_axis(eta: Float32) -> Float32:
    """z = √|(η − 1)/(η + 1)|."""
    z: Float32 = np.sqrt(np.abs((eta - 1.0) / (eta + 1.0)))
    return z


# ------------------------------------------------------------------------- tables


@cache
def _tables() -> dict[str, Float32]:
    with np.load(Path(__file__).with_name("tables.npz"), allow_pickle=False) as file:
        tables = {name: np.ascontiguousarray(file[name], np.float32) for name in file.files}
    return tables | _inner(tables["passed"], tables["inner_average"])


def _inner(passed: Float32, inner_average: Float32) -> dict[str, Float32]:
    """2∫ `passed` cosθ d(cosθ), exactly as interpolated, and what is lost of diffuse light inside."""
    step = 1.0 / (passed.shape[2] - 1)
    weights = 2.0 * step * np.linspace(0.0, 1.0, passed.shape[2])  # of a hat function: 2∫ hat(c) c dc
    weights[0], weights[-1] = step * step / 3.0, step - step * step / 3.0
    average = (passed * weights).sum(axis=2)
    z = np.linspace(0.0, 1.0, passed.shape[1])
    loss = 1.0 - average * ((1.0 - z * z) / (1.0 + z * z)) ** 2 - inner_average
    loss[0] = 0.0  # smooth
    return {
        "passed_average": average.astype(np.float32),
        "inner_loss": np.maximum(loss, 0.0).astype(np.float32),
    }


def _row2(name: str, x: Float32, z: Float32, block: Int32) -> Float32:
    """Table [X, blocks of 16 Z]: along x, then z within the block."""
    table = _tables()[name]
    width = table.shape[1]
    i, t = cell(x, table.shape[0])
    k, v = cell(z, 16)
    base = i * width + k + 16 * block
    table = table.ravel()
    low = lerp(table, base, base + width, t)
    high = lerp(table, base + 1, base + width + 1, t)
    value: Float32 = low + v * (high - low)
    return value


def _lookup3(name: str, x: Float32, z: Float32, block: Int32, y: Float32) -> Float32:
    """Table [X, blocks of 16 Z, Y]: along z within the block, then x, then y."""
    table = _tables()[name]
    k, v = cell(z, 16)
    k = k + 16 * block
    if k.size == 1:  # one index: blend two layers once
        layer = table[:, k[0]] + v[0] * (table[:, k[0] + 1] - table[:, k[0]])
        return plane(layer, x, y)
    width, columns = table.shape[1:]
    i, t = cell(x, table.shape[0])
    j, u = cell(y, columns)
    table = table.ravel()
    base = (i * width + k) * columns + j
    low = _plane(table, base, width * columns, columns, t, v)
    high = _plane(table, base + 1, width * columns, columns, t, v)
    value: Float32 = low + u * (high - low)
    return value


def _plane(table: Float32, base: Int32, step_x: int, step_z: int, t: Float32, v: Float32) -> Float32:
    low = lerp(table, base, base + step_z, v)
    high = lerp(table, base + step_x, base + step_x + step_z, v)
    value: Float32 = low + t * (high - low)
    return value
