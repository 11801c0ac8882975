"""Scattering at its limits: grazing, index-matched, critical, smooth, rough, black, and more than white."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import conductor, dielectric, fresnel
from ..core.distributions import ONE_BELOW
from ..scene.snapshot import Graph, Link, Node
from . import scenes as make
from .case import Group
from .geometry import FLOOR, radiance, worst

SCATTERING = Group("Scattering")
Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
COSINES = np.array([1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.5, 1.0])


def f32(*values: float) -> Float32:
    """(1,) or (3, 1) parameters."""
    array = np.array(values, np.float32)
    return array if len(values) == 1 else array[:, None]


def at_cosine(cos: Float64 | float, phi: float = 0.3) -> Float32:
    """(3, n) directions above the surface."""
    cos = np.atleast_1d(np.asarray(cos, np.float64))
    sin = np.sqrt((1 - cos) * (1 + cos))
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), cos]).astype(np.float32)


def grid(rows: int = 48) -> Float32:
    """(2, rows²) midpoints of the unit square."""
    x = ((np.arange(rows) + 0.5) / rows).astype(np.float32)
    return np.stack([axis.ravel() for axis in np.meshgrid(x, x)])


def albedo(model: ModuleType, params: Any, cos: float) -> float:
    """E[weight] of red toward a viewer at `cos`; NaN if a weight is not finite or negative."""
    u, v = grid()
    wi = np.repeat(at_cosine(cos), u.size, axis=1)
    choice = (np.arange(u.size) * 0.6180339887 % 1.0).astype(np.float32)
    s = model.sample(params, wi, np.minimum(choice, np.float32(ONE_BELOW)), u, v)
    weight = s.weight[0].astype(np.float64)
    good = np.isfinite(weight).all() and np.isfinite(s.pdf).all() and weight.min() >= 0 and s.pdf.min() >= 0
    return float(weight.mean()) if good else float("nan")


@SCATTERING.case(
    "index 1, 1 ± 1e-7, below 1, 100, 0",
    "nothing to refract, nothing to mask; or hardly anything that passes",
    "largest gain of energy of glass, all roughnesses and angles, in a white furnace",
    0.0,
    1e-5,
    "rounding of a mean of weights of 1",
)
def indices() -> float:
    values = [
        albedo(dielectric, dielectric.Params(f32(alpha), f32(eta)), float(cos))
        for eta in (1.0, 1 + 1e-7, 1 - 1e-7, 0.3, 100.0, 1e-5)
        for alpha in (0.0, 1e-4, 0.05, 1.0)
        for cos in COSINES
    ]
    return float("nan") if np.isnan(values).any() else max(max(values) - 1, 0.0)


@SCATTERING.case(
    "an index of 1 is not there",
    "a refracted direction that differs from the straight one by a rounding has a density of 1e12",
    "radiance of a sky through rough glass of index 1 + 1e-7",
    1.0,
    1e-4,
    "the table of what bounces between facets is linear in √|η − 1|: 6e-5",
)
def invisible() -> float:
    glass = make.shader("BsdfGlass", "g", Color=make.WHITE, Roughness=0.3, IOR=1 + 1e-7)
    return radiance(make.sphere(0.4, 16), material=glass, depth=20)


@SCATTERING.case(
    "total reflection at the critical angle",
    "g² = η² − 1 + c² crosses 0: roots of −1e-9, and F must be 1 to the digit beyond",
    "deviation of F from 1 below the critical cosine, plus its jump there",
    0.0,
    5e-3,
    "F rises with a vertical tangent: 2⁻²⁴ of the cosine are 2e-3 of F",
)
def critical() -> float:
    eta = np.float32(1 / 1.5)
    edge = np.sqrt(1 - float(eta) ** 2)
    cos = (edge + np.array([-1e-3, -1e-6, -1e-7, 1e-7])).astype(np.float32)
    f, g = fresnel.dielectric(cos, np.full(4, eta))
    return float(np.abs(f - 1).max()) + (0.0 if np.isfinite(g).all() else float("nan"))


@SCATTERING.case(
    "roughness down to 1e-8, continuous to the mirror",
    "a lobe of 1e-5 is as wide as float32's spacing of directions; below it is a Dirac lobe",
    "largest step of the albedo of glass and of metal, α = 0, 1e-8, … 1e-3",
    0.0,
    1e-3,
    "at a cosine of 0.05 the albedo itself falls by some (α/cosθ)²",
)
def smooth_limit() -> float:
    alphas = (0.0, 1e-8, 1e-6, 1e-5, 1.4e-5, 1.5e-5, 1e-4, 1e-3)
    steps = []
    for cos in (0.05, 0.5, 1.0):
        metal = [albedo(conductor, conductor.Params(f32(a)), cos) for a in alphas]
        glass = [albedo(dielectric, dielectric.Params(f32(a), f32(1.5)), cos) for a in alphas]
        steps += [*np.abs(np.diff(metal)), *np.abs(np.diff(glass))]
    return max(steps) if not np.isnan(steps).any() else float("nan")


@SCATTERING.case(
    "albedo 1 at every roughness and angle",
    "no energy may come of rounding, however grazing the view",
    "largest gain of white metal in a white furnace",
    0.0,
    1e-5,
    "rounding of a mean of weights of 1",
)
def furnace() -> float:
    values = [
        albedo(conductor, conductor.Params(f32(ax), f32(ay)), float(cos))
        for ax, ay in ((0.0, 0.0), (1e-3, 1.0), (1.0, 1e-3), (0.3, 0.3), (1.0, 1.0))
        for cos in COSINES
    ]
    return float("nan") if np.isnan(values).any() else max(max(values) - 1, 0.0)


@SCATTERING.case(
    "anisotropy of 1 : 1000",
    "a lobe thin as a wire: its density is 1e6 along one axis",
    "integral of the density over the lobe, by its own samples: mean of value/pdf over the mean weight",
    1.0,
    2e-3,
    "the half vector is found again from float32 directions",
)
def wire() -> float:
    u, v = grid(64)
    wi = np.repeat(at_cosine(0.6, 0.9), u.size, axis=1)
    params = conductor.Params(f32(1e-3), f32(1.0))
    s = conductor.sample(params, wi, u, u, v)
    value, pdf = conductor.eval_pdf(params, wi, s.wo)
    kept = np.flatnonzero((s.weight[0] > 0) & (pdf > 0))
    return float((value[0, kept] / pdf[kept]).mean() / s.weight[0, kept].mean())


@SCATTERING.case(
    "1,000 refractions without gain or loss",
    "a throughput multiplied a thousand times",
    "throughput after 1,000 interfaces of clear glass, the worst of 2,000 paths",
    1.0,
    1e-4,
    "a thousand roundings of 6e-8",
)
def thousand() -> float:
    rng = np.random.default_rng(2)
    beta: Float32 = np.ones(2000, np.float32)
    params = dielectric.Params(f32(0.0), f32(1.5))
    for _ in range(1000):
        wi = at_cosine(rng.random(beta.size))
        beta *= dielectric.sample(params, wi, *rng.random((3, beta.size), np.float32)).weight[0]
    return worst([float(np.min(beta)), float(np.max(beta))], 1.0)


@SCATTERING.case(
    "albedo 1 for 1,000 bounces",
    "all the light of a closed box goes round and round",
    "radiance in a white box whose walls shine 1e-3, all 1,000 bounces added up",
    1.0,
    5e-3,
    "noise of 128,000 vertices' emitter samples",
    quick=False,
)
def white_box() -> float:
    box = (make.box(2.0), np.eye(4), make.shining_diffuse(1.0, 1e-3))
    snapshot = make.scene([box], make.perspective((0.1, 0.2, -0.3), (0, 1, 0)))
    result = make.rendered(snapshot, 4, samples=8, max_depth=1000, integrator="path_active")
    return float(result.image()[..., :3].mean())


@SCATTERING.case(
    "nested dielectrics, coat on glass",
    "paths of many refractions, where a loss or gain at one interface would show often",
    "radiance of a white sky through glass in glass, and through coated glass, all clear",
    1.0,
    5e-3,
    "paths of more than 200 edges are cut",
)
def nested() -> float:
    inner = make.shader("BsdfGlass", "inner", Color=make.WHITE, Roughness=0.0, IOR=1.7)
    outer = make.shader("BsdfGlass", "outer", Color=make.WHITE, Roughness=0.0, IOR=1.3)
    coated = make.shader(
        "BsdfPrincipled",
        "coated",
        Base_Color=make.WHITE,
        Roughness=0.0,
        IOR=1.5,
        Transmission_Weight=1.0,
        Coat_Weight=1.0,
        Coat_Roughness=0.0,
        Coat_IOR=1.5,
    )
    nest = [(make.sphere(0.45, 16), np.eye(4), outer), (make.sphere(0.25, 16), np.eye(4), inner)]
    camera = make.orthographic((0.03, 0.02, 3), (0.03, 0.02, 0), 0.9)
    snapshot = make.scene(nest, camera, sky=make.world(1.0))
    result = make.rendered(snapshot, 8, samples=64, max_depth=200, integrator="path_active")
    first = float(result.image()[..., :3].mean())
    return worst([first, radiance(make.sphere(0.4, 16), material=coated, depth=200)], 1.0)


@SCATTERING.case(
    "black, negative, NaN and infinite colours",
    "what the user can type or compute must not reach the film",
    "radiance of such a diffuse surface (NaN where a sample had to be dropped)",
    0.0,
    0.0,
    "negative and undefined colours are black, as in Cycles",
)
def colours() -> float:
    bad = (0.0, -0.5, -1e30, float("nan"), float("inf"), -float("inf"))
    return worst([radiance(FLOOR, material=make.diffuse(c), depth=3) for c in bad], 0.0)


@SCATTERING.case(
    "colours above 1",
    "roulette's probability is at most 1, whatever the throughput",
    "radiance of an albedo of 4 in a white sky, over 4",
    1.0,
    5e-3,
    "noise",
)
def more_than_white() -> float:
    return radiance(FLOOR, material=make.diffuse(4.0), depth=8, integrator="path") / 4


@SCATTERING.case(
    "weights that cancel",
    "the mean of a closure's weight is 0 where its channels cancel: it would never be sampled",
    "green radiance of a sum of the colours (1, −1, 0) and (0, 1, 0), over that without the first",
    1.0,
    5e-3,
    "a negative weight is none, as in Cycles; noise",
)
def cancelling() -> float:
    def sum_of(first: tuple[float, float, float]) -> Graph:
        nodes = (
            Node("BsdfDiffuse", "a", {"Color": make.rgba(first), "Roughness": 0.0}),
            Node("BsdfDiffuse", "b", {"Color": make.rgba((0, 0.5, 0)), "Roughness": 0.0}),
            Node("AddShader", "sum", {"Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")}),
        )
        return Graph("sum", nodes, {"Surface": Link(2, "Shader")})

    camera = make.orthographic((0, 0, 3), (0, 0, 0), 0.9)

    def green(graph: Graph) -> float:
        snapshot = make.scene([(FLOOR, np.eye(4), graph)], camera, sky=make.world(1.0))
        result = make.rendered(snapshot, 8, samples=64, sampler="sobol", max_depth=2)
        return float(result.image()[..., 1].mean())

    return green(sum_of((0.5, -0.5, 0))) / green(sum_of((0.5, 0, 0)))
