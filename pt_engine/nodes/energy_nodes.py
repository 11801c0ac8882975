"""What rough closures gain by light that bounces between facets, and what gloss leaves to the layers below.

The models are in `bsdfs.energy`; here are the ops, split so that what depends on constants alone is folded.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import conductor, energy, thin_film
from ..bsdfs import fresnel as law
from ..core import vectors
from .graph import NodeView
from .ir import COLOR, FLOAT, Op, Value, lane_op, op
from .roughness import Rough
from .surface import is_constantly

Float32 = NDArray[np.float32]
GRAZING: Final = np.float32(1e-4)


@lane_op(FLOAT)
def viewer_cosine(lanes: Any, *normal: Float32) -> Float32:
    """Cosine between the viewer and the normal, kept positive."""
    return np.maximum(vectors.dot(lanes.wi, normal[0] if normal else lanes.ns), GRAZING)


def cosine(n: NodeView, normal: Value | None) -> Value:
    """The viewer's cosine against a normal (None: the shading normal)."""
    return n.call(viewer_cosine) if normal is None else n.call(viewer_cosine, normal)


@lane_op(FLOAT)
def mirror_cosine(lanes: Any, *normal: Float32) -> Float32:
    """The same where a mirror's direction leaves the surface: normals that bend too far are raised."""
    n = normal[0] if normal else lanes.ns
    raised = getattr(lanes, "raised", None)
    if raised is not None and (normal or lanes.smooth):
        n = raised(normal[0] if normal else None)
    return np.maximum(vectors.dot(lanes.wi, n), GRAZING)


def glossy_cosine(n: NodeView, normal: Value | None) -> Value:
    """The viewer's cosine against the normal about which a gloss reflects."""
    return n.call(mirror_cosine) if normal is None else n.call(mirror_cosine, normal)


# ------------------------------------------------------------------ gains


def _alphas(has_y: bool, values: tuple[Float32, ...]) -> tuple[Float32, Float32 | None]:
    return values[0], values[1] if has_y else None


@op(COLOR)
def reflection_gain(has_y: bool, average: Float32, cos: Float32, *alphas: Float32) -> Float32:
    """`energy.reflection_gain` for facets of some average reflectance."""
    gain = energy.reflection_gain(*_alphas(has_y, alphas), cos, average)
    return np.broadcast_to(gain, (3, gain.shape[1]))


@op(COLOR)
def glass_gain(average: Float32, cos: Float32, alpha: Float32, eta: Float32) -> Float32:
    """`energy.glass_gain` for glass of some colour."""
    return energy.glass_gain(alpha, eta, cos, average)


@op(COLOR)
def tinted_average(color: Float32, edge_tint: Float32) -> Float32:
    """Mean reflectance of F82 metal."""
    return np.broadcast_to(conductor.average(_metal(color=color, edge_tint=edge_tint)), color.shape)


@op(COLOR)
def complex_average(eta: Float32, k: Float32) -> Float32:
    """Mean reflectance of a conductor of complex index."""
    return np.asarray(conductor.average(_metal(eta=eta, k=k)))


def _metal(**fresnel: Float32) -> conductor.Params:
    return conductor.Params(alpha_x=np.ones(1, np.float32), **fresnel)


def gained(n: NodeView, weight: Value, rough: Rough, average: Value, normal: Value | None) -> Value:
    """A reflection's weight with what its facets' interreflection adds."""
    if rough.is_smooth:
        return weight
    alphas = [rough.alpha_x] if rough.alpha_y is None else [rough.alpha_x, rough.alpha_y]
    static = (rough.alpha_y is not None,)
    gain = n.call(reflection_gain, average, glossy_cosine(n, normal), *alphas, static=static)
    return n.builder.multiply(weight, gain)


def glass_gained(
    n: NodeView, weight: Value, rough: Rough, eta: Value, average: Value, normal: Value | None
) -> Value:
    """The same for glass."""
    if rough.is_smooth:
        return weight
    gain = n.call(glass_gain, average, glossy_cosine(n, normal), rough.alpha_x, eta)
    return n.builder.multiply(weight, gain)


# ------------------------------------------------------------------ gloss over something


@op(COLOR, COLOR)
def gloss_colors(eta: Float32, tint: Float32) -> tuple[Float32, Float32]:
    """Reflectance of tinted gloss at normal incidence, and its average over the hemisphere."""
    f0 = law.normal_incidence(eta)
    base: Float32 = np.minimum(f0 * tint, 1)
    rise = (law.dielectric_average(eta) - f0) / np.maximum(1 - f0, np.float32(1e-6))
    average = (base + (1 - base) * np.clip(rise, 0, 1)).astype(np.float32, copy=False)
    return base, average


@op(COLOR)
def glass_average(through: Float32, eta: Float32, tint: Float32) -> Float32:
    """What stands for the facets' colour in glass: what it lets through, or if that is black its gloss."""
    _, average = gloss_colors.function(eta, tint)
    black = ~(through > 0).any(axis=0)
    out: Float32 = np.where(black, average, through).astype(np.float32, copy=False)
    return out


def _gloss_layer(
    has_y: bool,
    multiscatter: bool,
    grey: bool,
    dark: bool,
    base: Float32,
    average: Float32,
    cos: Float32,
    eta: Float32,
    *more: Float32,
) -> tuple[Float32, Float32]:
    """The factor of a gloss' weight, and 1 − its directional albedo's largest component.

    `more`: the roughness; with a film, its thickness and index and the gloss' tint; if `dark`, the weight,
    of which components of 0 do not count.
    """
    pair, film = _alphas(has_y, more), more[1 + has_y : len(more) - dark]
    if grey:
        base, average = base[:1], average[:1]
    s = energy.gloss(*pair, eta, cos)
    albedo: Float32 = base + (1 - base) * s
    if film:
        albedo = _under_film(albedo, cos, eta, *film)
    gain: Float32 = np.ones((1, 1), np.float32)
    if multiscatter:
        white = energy.reflection_albedo(*pair, cos)
        gain = energy.gain_over(white, *pair, average)
        albedo = albedo * (gain * white)
    if dark:
        albedo = albedo * (more[-1] > 0)
    left: Float32 = np.clip(1 - albedo.max(axis=0), 0, 1)
    return (gain[0] if grey else np.broadcast_to(gain, (3, gain.shape[1]))), left


def _under_film(
    bare: Float32, cos: Float32, eta: Float32, thickness: Float32, ior: Float32, tint: Float32
) -> Float32:
    """Albedo with a film where there is one: a mirror's, whatever the roughness, as in Cycles."""
    film = thin_film.Film(thickness, ior)
    return thin_film.covered(film, cos, lambda c, f: thin_film.over_tinted(c, eta, tint, f), lambda _: bare)


gloss_grey: Final = Op(_gloss_layer, (FLOAT, FLOAT))
gloss_tinted: Final = Op(_gloss_layer, (COLOR, FLOAT))


def gloss_layer(
    n: NodeView,
    rough: Rough,
    eta: Value,
    tint: Value,
    normal: Value | None,
    multiscatter: bool,
    film: Mapping[str, Value],
    dark: Value | None = None,
) -> tuple[Value, Value]:
    """Factor of a dielectric gloss' weight, and the share it leaves to what is below.

    `film`: of `thin_films.film_params`. `dark`: the gloss' weight, where a component of it may be 0.
    """
    base, average = n.calls(gloss_colors, eta, tint)
    grey = is_constantly(tint, 1)
    alphas = [rough.alpha_x] if rough.alpha_y is None else [rough.alpha_x, rough.alpha_y]
    static = (rough.alpha_y is not None, multiscatter and not rough.is_smooth, grey, dark is not None)
    what = gloss_grey if grey else gloss_tinted
    more = [film["film_thickness"], film["film_ior"], tint] if film else []
    more += [] if dark is None else [dark]
    gain, left = n.calls(what, base, average, glossy_cosine(n, normal), eta, *alphas, *more, static=static)
    return gain, left
