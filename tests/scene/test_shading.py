"""The sum of closures on a wavefront: which is chosen, how likely the direction was, what it carries."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import kstest
from support.chi2 import chi2_counts, chi2_sphere, integrate_sphere, significance
from support.hits import random_directions, unit

from pt_engine.bsdfs import conductor, diffuse, translucent, transparent
from pt_engine.bsdfs.base import BSDFSample, Lobe
from pt_engine.core import frames, vectors
from pt_engine.nodes.batch import Closure
from pt_engine.scene.raised_normal import raised_normal
from pt_engine.scene.shading import Scattered, ShadedBSDF, SliceBSDF, choose

BELOW_ONE = np.float32(1 - 2**-24)
Z = unit([(0, 0, 1)])
WI = unit([(0.5, -0.2, 0.8)])
GLOSS = conductor.Params(np.full(1, 0.3, np.float32))
MIRROR = conductor.Params(np.zeros(1, np.float32))
P_VALUE = significance(12)


def colour(*rgb: float) -> np.ndarray:
    return np.array(rgb, np.float32)[:, None]


def closure(bsdf, params, weight, normal=None):
    """On one normal for all lanes; `normal` (3, 1) bends it."""
    return Closure(bsdf, params, weight, normal, None)


def lambert(weight, normal=None):
    return closure(diffuse, diffuse.Params(), weight, normal)


def behind(weight, normal=None):
    return closure(translucent, translucent.Params(), weight, normal)


def straight(weight):
    return closure(transparent, transparent.Params(), weight)


def fake_lanes(n, wi=WI, ns=Z, ng=Z, smooth=False):
    """Lanes that are all alike."""
    wide = [np.ascontiguousarray(np.broadcast_to(v, (3, n))) for v in (wi, ns, ng)]
    lanes = SimpleNamespace(n=n, wi=wide[0], ns=wide[1], ng=wide[2], horizon=wide[2], smooth=smooth)
    lanes.raised = lambda normal: raised_normal(lanes.ng, lanes.wi, lanes.ns if normal is None else normal)
    return lanes


def shaded(closures, n, **more) -> SliceBSDF:
    full = [
        c if c.normal is None else c._replace(normal=np.ascontiguousarray(np.broadcast_to(c.normal, (3, n))))
        for c in closures
    ]
    return SliceBSDF(full, fake_lanes(n, **more))


def drawn(bsdf: SliceBSDF, u: np.ndarray) -> Scattered:
    return ShadedBSDF(u.shape[1], [(slice(0, u.shape[1]), bsdf)], u.shape[1]).sample(u)


def uniforms(n, seed=1):
    return np.random.default_rng(seed).random((3, n), np.float32)


# ------------------------------------------------------------------ choice


SHARES = [(1.0,), (0.3, 0.7), (0.25, 0.0, 0.75), (0.0, 1.0), (1.0, 0.0), (0.1, 0.2, 0.3, 0.4), (1e-3, 0.999)]


@pytest.mark.parametrize("shares", SHARES, ids=str)
def test_choice_frequencies_are_the_shares(shares):
    """On a lattice of u the counts are exact to one cell per boundary; a share of 0 is never chosen."""
    n = 1 << 20
    u = (np.arange(n, dtype=np.float64) / n).astype(np.float32)
    choice, left = choose([np.full(1, s, np.float32) for s in shares], u)
    counts = np.bincount(choice, minlength=len(shares))
    np.testing.assert_allclose(counts, np.array(shares) * n, atol=1.001)
    assert (counts[np.array(shares) == 0] <= 1).all()
    assert left.min() >= 0
    assert left.max() <= BELOW_ONE


@pytest.mark.parametrize("shares", SHARES, ids=str)
def test_what_is_left_of_the_uniform_is_uniform(shares):
    """Within each choice, so that it can be used again; Kolmogorov and Smirnov, over all of [0, 1)."""
    u = np.random.default_rng(3).random(200_000, np.float32)
    choice, left = choose([np.full(1, s, np.float32) for s in shares], u)
    for k, share in enumerate(shares):
        if share > 0:
            assert kstest(left[choice == k], "uniform").pvalue > significance(30)


def test_choice_goes_lane_by_lane():
    """Shares differ per lane, one of them broadcast or not; alone the same bits."""
    rng = np.random.default_rng(4)
    raw = rng.random((3, 500)).astype(np.float32)
    shares, u = list(raw / raw.sum(axis=0)), rng.random(500, np.float32)
    choice, left = choose(shares, u)
    upto = np.cumsum(np.float64(shares), axis=0)
    assert (choice == (u >= upto[:2]).sum(axis=0)).all()
    low = np.concatenate([np.zeros((1, 500)), upto])[choice, np.arange(500)]
    expected = (u - low) / np.float64(shares)[choice, np.arange(500)]
    np.testing.assert_allclose(left, expected, atol=1e-5)
    one, leftover = choose([s[7:8] for s in shares], u[7:8])
    assert (one[0], leftover[0]) == (choice[7], left[7])


@pytest.mark.parametrize(("shares", "last"), [([1 / 3] * 3, 2), ([0, 0.33, 0, 0.33, 0.33, 0, 0], 4)])
@pytest.mark.parametrize("lanes", [1, 2])
def test_the_last_uniform_below_one_finds_a_choice(shares, last, lanes):
    """Rounding may leave Σ shares below 1: the last closure that has a share takes the rest."""
    choice, left = choose([np.full(lanes, s, np.float32) for s in shares], np.array([BELOW_ONE] * 2, "f4"))
    assert choice.tolist() == [last, last]
    assert left.min() > 0.999
    assert left.max() < 1


def test_shares_sum_to_one_and_follow_what_is_scattered():
    """In proportion to mean weight times albedo; a lone closure has it all; no light, no share."""
    n = 5
    two = shaded([lambert(colour(0.6, 0.3, 0)), behind(colour(0.1, 0.1, 0.1))], n)
    np.testing.assert_allclose(two.shares[0], 0.75, rtol=1e-6)
    np.testing.assert_allclose(sum(two.shares), 1, rtol=1e-6)
    one = shaded([lambert(colour(0, 0, 0))], n)
    np.testing.assert_array_equal(one.shares[0], 1)
    none = shaded([lambert(colour(0, 0, 0))] * 2, n)
    np.testing.assert_array_equal(sum(none.shares), 0)
    out = drawn(none, uniforms(n))
    assert (out.weight == 0).all()
    assert np.isfinite(out.wo).all()


# ------------------------------------------------------------------ mixtures


BENT = unit([(-0.4, 0.3, 1.0)])
MIXES = {
    "lambert + gloss": [
        lambert(colour(0.5, 0.4, 0.1)),
        closure(conductor, GLOSS, colour(0.3, 0.3, 0.3)),
    ],
    "lambert + bent gloss": [
        lambert(colour(0.5, 0.4, 0.1)),
        closure(conductor, GLOSS, colour(0.3, 0.3, 0.3), BENT),
    ],
    "bent lambert + translucent": [
        lambert(colour(0.2, 0.6, 0.1), BENT),
        behind(colour(0.7, 0.1, 0.4)),
    ],
    "three": [
        lambert(colour(0.2, 0.2, 0.2)),
        behind(colour(0.3, 0.3, 0.3)),
        closure(conductor, GLOSS, colour(0.4, 0.4, 0.4)),
    ],
    "one": [closure(conductor, GLOSS, colour(0.4, 0.2, 0.4))],
    "bent lambert": [lambert(colour(0.4, 0.2, 0.4), BENT)],
}


@pytest.mark.parametrize("name", MIXES)
@pytest.mark.parametrize("smooth", [False, True], ids=["flat", "smooth"])
def test_directions_follow_the_summed_density(name, smooth):
    """χ² of `sample` against pdf = Σ share · pdf_k; with an interpolated normal, what fails is not drawn.

    Where the shading normal differs from the true one, density behind the surface is cut off, so the
    integral falls short of 1 by just what the sampler rejects.
    """
    more = {"ns": unit([(0.3, 0.1, 1.0)]), "smooth": True} if smooth else {}

    def draw(u0, u1, u2):
        s = drawn(shaded(MIXES[name], len(u0), **more), np.stack([u0, u1, u2]))
        return s.wo, vectors.max3(s.weight) > 0

    def pdf(wo):
        return shaded(MIXES[name], wo.shape[1], **more).eval_pdf(wo)[1]

    assert chi2_sphere(draw, pdf, n=60_000, resolution=(16, 24)) > P_VALUE
    assert integrate_sphere(pdf) < 1 + 1e-4


@pytest.mark.parametrize("name", MIXES)
def test_the_weight_is_value_over_density(name):
    """weight = Σ w_k f_k cosθ / Σ share_k pdf_k at the direction drawn, to its rounding."""
    n = 4000
    bsdf = shaded(MIXES[name], n)
    s = drawn(bsdf, uniforms(n))
    value, pdf = bsdf.eval_pdf(s.wo)
    good = vectors.max3(s.weight) > 0
    assert good.mean() > 0.8
    np.testing.assert_allclose((s.weight * s.pdf)[:, good], value[:, good], rtol=2e-3, atol=1e-6)
    np.testing.assert_allclose(s.pdf[good], pdf[good], rtol=2e-3)
    np.testing.assert_allclose(vectors.length(s.wo[:, good]), 1, atol=1e-5)


def test_the_density_is_the_share_weighted_sum():
    """pdf = Σ share_k pdf_k and value = Σ weight_k f_k, of the closures taken one by one."""
    wo = np.ascontiguousarray(random_directions(1000, 5).T, np.float32)
    for closures in MIXES.values():
        bsdf = shaded(closures, 1000)
        value, pdf = bsdf.eval_pdf(wo)
        alone = [shaded([c], 1000).eval_pdf(wo) for c in closures]
        bent = any(c.normal is not None for c in closures)
        valid = [np.ones(1000)] * len(closures)
        if bent:  # the side test then holds for all closures of the batch
            normals = [Z if c.normal is None else c.normal for c in closures]
            valid = [vectors.dot(Z, wo) * vectors.dot(n, wo) > 0 for n in normals]
        expected = sum(s * p * v for s, (_, p), v in zip(bsdf.shares, alone, valid, strict=True))
        np.testing.assert_allclose(pdf, expected * np.ones(1000), rtol=1e-5, atol=1e-9)
        total = sum(f * v for (f, _), v in zip(alone, valid, strict=True))
        np.testing.assert_allclose(value, total * np.ones((3, 1000)), rtol=1e-5, atol=1e-9)


def test_a_mixture_scatters_what_its_parts_scatter():
    """E[weight] = Σ weight_k · E_k[weight]: 0.5 + 0.3 of white Lambert and white Lambert transmission."""
    parts = [lambert(colour(0.5, 0, 0.1)), behind(colour(0.3, 0.9, 0.1))]
    n = 100_000
    s = drawn(shaded(parts, n), uniforms(n, 6))
    weight = s.weight.astype(np.float64)
    error = weight.std(axis=1) / np.sqrt(n)
    assert (np.abs(weight.mean(axis=1) - (0.8, 0.9, 0.2)) < 4.5 * error + 1e-5).all()


# ------------------------------------------------------------------ Dirac lobes


def test_dirac_lobes_in_a_mix():
    """Chosen with their share, density ∞, weight = closure weight / share; no part of the others' pdf."""
    n = 50_000
    parts = [
        lambert(colour(0.2, 0.4, 0.6)),
        closure(conductor, MIRROR, colour(0.3, 0.3, 0.3)),
        straight(colour(0.3, 0.0, 0.0)),
    ]
    bsdf = shaded(parts, n)
    shares = [float(np.broadcast_to(s, n)[0]) for s in bsdf.shares]
    np.testing.assert_allclose(shares, np.array([0.4, 0.3, 0.1]) / 0.8, rtol=1e-5)
    s = drawn(bsdf, uniforms(n, 7))
    through = (s.lobe & Lobe.TRANSPARENT) != 0
    mirrored = ((s.lobe & Lobe.DELTA) != 0) & ~through
    scattered = ~(through | mirrored)
    assert chi2_counts([scattered.sum(), mirrored.sum(), through.sum()], np.array(shares) * n) > P_VALUE
    wide = np.broadcast_to(WI, (3, n))
    np.testing.assert_allclose(s.wo[:, through], -wide[:, through], atol=1e-6)
    np.testing.assert_allclose(s.wo[:, mirrored], vectors.reflect(WI, Z) * np.ones(mirrored.sum()), atol=1e-5)
    assert np.isinf(s.pdf[through | mirrored]).all()
    assert np.isfinite(s.pdf[scattered]).all()
    np.testing.assert_allclose(
        s.weight[:, through], colour(0.3, 0, 0) / shares[2] * np.ones(through.sum()), rtol=1e-5
    )
    np.testing.assert_allclose(s.weight[:, mirrored], 0.3 / shares[1], rtol=1e-4)
    lit = s.weight[:, scattered]
    np.testing.assert_allclose(lit, colour(0.2, 0.4, 0.6) / shares[0] * np.ones(lit.shape[1]), rtol=1e-4)
    value, pdf = bsdf.eval_pdf(s.wo)
    np.testing.assert_allclose(pdf[scattered], shares[0] * s.wo[2, scattered] / np.pi, rtol=1e-4, atol=1e-7)
    assert (value[:, through] == 0).all()


def test_a_straight_ray_passes_whatever_the_shading_normal():
    """Transparency knows no sides: it is not rejected where ns and ng disagree about wo."""
    n = 1000
    only = shaded([straight(colour(0.7, 0.7, 0.7))], n, ns=unit([(2, 0, 0.1)]), smooth=True)
    mixed = shaded(
        [lambert(colour(0.5, 0.5, 0.5)), straight(colour(0.5, 0.5, 0.5))],
        n,
        ns=unit([(-2, 0, 0.1)]),
        smooth=True,
    )
    assert (drawn(only, uniforms(n)).weight > 0).all()
    s = drawn(mixed, uniforms(n))
    assert (s.weight[:, (s.lobe & Lobe.TRANSPARENT) != 0] > 0).all()


# ------------------------------------------------------------------ frames


def framed_diffuse():
    """Lambert through the general, framed way."""
    return SimpleNamespace(sample=diffuse.sample, eval_pdf=diffuse.eval_pdf, albedo=diffuse.albedo)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.3, -0.8, 0.1)])
def test_lambert_without_a_frame_is_lambert_with_one(normal):
    """The same density and value in every direction, and both samplers draw in proportion to it."""
    n = unit([normal])
    more = {"ns": n, "ng": n, "wi": n}
    white = colour(0.8, 0.8, 0.8)
    wo = np.ascontiguousarray(random_directions(2000, 8).T, np.float32)
    results = []
    for model in (diffuse, framed_diffuse()):
        closures = [closure(model, diffuse.Params(), white)]
        results.append(shaded(closures, 2000, **more).eval_pdf(wo))
        p = chi2_sphere(
            lambda *u, c=closures: (drawn(shaded(c, len(u[0]), **more), np.stack(u)).wo, None),
            lambda w, c=closures: shaded(c, w.shape[1], **more).eval_pdf(w)[1],
            n=50_000,
            resolution=(12, 20),
            pole=tuple(n[:, 0].tolist()),
        )
        assert p > P_VALUE
    for a, b in zip(*results, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_a_normal_turned_from_the_viewer_is_seen_grazing():
    """wi below an interpolated normal's horizon: the local cosine is lifted to above 0, nothing is NaN."""
    n = 500
    away = unit([(1, 0, 0.05)])  # the viewer is at −x
    for closures in MIXES.values():
        bsdf = shaded(closures, n, ns=away, wi=unit([(-1, 0, 0.2)]), smooth=True)
        s = drawn(bsdf, uniforms(n))
        value, pdf = bsdf.eval_pdf(s.wo)
        for array in (s.weight, s.wo, value, pdf):
            assert np.isfinite(array).all()
        assert (s.weight >= 0).all()
        assert bsdf.frames[0].wi[2].min() > 0


def test_no_light_leaks_through_a_smooth_surface():
    """wo on one side of the true surface and on the other of the shaded one: value, pdf, weight are 0."""
    n = 4000
    ns = unit([(0.8, 0, 0.6)])
    bsdf = shaded([lambert(colour(1, 1, 1))], n, ns=ns, smooth=True)
    s = drawn(bsdf, uniforms(n))
    leak = s.wo[2] <= 0
    # (1 − cosα)/2 of a cosine lobe lies beyond a plane tilted by α; here cosα = 0.6
    assert abs(leak.mean() - 0.2) < 4.5 * np.sqrt(0.2 * 0.8 / n)
    assert (s.weight[:, leak] == 0).all()
    value, pdf = bsdf.eval_pdf(s.wo)
    assert (value[:, leak] == 0).all()
    assert (pdf[leak] == 0).all()


# ------------------------------------------------------------------ wavefronts


def test_slices_are_shaded_each_by_its_own():
    """The wavefront's answer on each span is that of the span alone, bit for bit."""
    names = ["lambert + gloss", "one", "three"]
    spans = [slice(0, 100), slice(100, 137), slice(137, 300)]
    slices = [(span, shaded(MIXES[k], span.stop - span.start)) for span, k in zip(spans, names, strict=True)]
    mirror = shaded([closure(conductor, MIRROR, colour(1, 1, 1))], 50)
    whole = ShadedBSDF(350, [*slices, (slice(300, 350), mirror)], 300)
    u = uniforms(350, 9)
    s = whole.sample(u)
    wo = np.ascontiguousarray(random_directions(300, 10).T, np.float32)
    value, pdf = whole.eval_pdf(wo)
    assert pdf.shape == (300,)
    for span, bsdf in slices:
        alone = drawn(bsdf, u[:, span])
        for a, b in zip(s, alone, strict=True):
            np.testing.assert_array_equal(a[..., span], b)
        f, p = bsdf.eval_pdf(np.ascontiguousarray(wo[:, span]))
        np.testing.assert_array_equal(value[:, span], np.broadcast_to(f, (3, f.shape[-1])))
        np.testing.assert_array_equal(pdf[span], p)
    assert np.isinf(s.pdf[300:]).all()


def test_uniforms_reach_the_lobe_uniform():
    """A closure's own choice of lobe gets what is left of the number that chose the closure."""
    seen = []

    def sample(params, wi, u0, u1, u2):
        seen.append(u0)
        wo = np.ascontiguousarray(np.broadcast_to(Z, wi.shape))
        return BSDFSample(wo, np.ones(len(u0), np.float32), np.ones((1, len(u0)), np.float32), Lobe.GLOSSY)

    def eval_pdf(params, wi, wo):
        return np.ones((1, wo.shape[1]), np.float32), np.ones(wo.shape[1], np.float32)

    spy = SimpleNamespace(sample=sample, eval_pdf=eval_pdf, albedo=lambda params, cos: np.ones(1, np.float32))
    n = 20_000
    parts = [closure(spy, (), colour(0.2, 0.2, 0.2)), closure(spy, (), colour(0.6, 0.6, 0.6))]
    drawn(shaded(parts, n), uniforms(n, 11))
    assert len(seen) == 2
    assert len(seen[0]) + len(seen[1]) == n
    for u0 in seen:
        assert kstest(u0, "uniform").pvalue > P_VALUE


def test_tangents_turn_the_frame():
    """s along the tangent made orthogonal to the normal; s × t = n."""
    n, t = unit(random_directions(200, 12)), unit(random_directions(200, 13))
    along_s, along_t = frames.from_tangent(n, t)
    one = Closure(diffuse, diffuse.Params(), colour(1, 1, 1), n, t)
    bsdf = SliceBSDF([one], fake_lanes(200))
    np.testing.assert_array_equal(bsdf.frames[0].axes[0], along_s)
    np.testing.assert_array_equal(bsdf.frames[0].axes[1], along_t)
    assert vectors.dot(along_s, t).min() > 0
    np.testing.assert_allclose(vectors.cross(along_s, along_t), n, atol=1e-5)
