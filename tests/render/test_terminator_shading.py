"""The shading offset: light fades as the closed form says, gains nothing, and all strategies agree."""

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean, assert_within_standard_errors, mean_and_error
from support.rooms import ROUGH, SOFT_LAMP, room

from pt_engine.scene.prepare import prepare
from pt_engine.scene.terminator_shading import fade


def offset(snapshot, value):
    rows = np.full(len(snapshot.instances.mesh), value, np.float32)
    return replace(snapshot, instances=replace(snapshot.instances, shading_offset=rows))


def plane(material):
    camera = make.orthographic((0, 0, 5), (0, 0, 0), 1.0)
    return make.scene([(make.quad(8.0), np.eye(4), material)], camera, sky=make.world(1.0))


@pytest.mark.parametrize("value", [0.5, 1.0])
def test_lambert_under_a_white_sky_keeps_what_the_closed_form_says(value):
    """2 ∫ cos fθ sin θ dθ from 0 to a = π/(2f): (cos θ cos fθ + f sin θ sin fθ) / (f² − 1) between them."""
    f = 1 / (1 - value / 2)
    kept = 2 * (f * np.sin(np.pi / (2 * f)) - 1) / (f * f - 1)
    result = make.rendered(offset(plane(make.diffuse(1.0)), value), 8, samples=64, max_depth=2)
    assert_within_standard_errors(result, kept)
    assert 0.2 < kept < 0.8


@pytest.mark.parametrize("kind", ["BsdfDiffuse", "BsdfGlossy", "BsdfGlass", "BsdfTranslucent", "BsdfSheen"])
def test_no_closure_gains_in_a_furnace(kind):
    more = {} if kind == "BsdfTranslucent" else {"Roughness": 0.4}
    snapshot = plane(make.shader(kind, kind, Color=make.WHITE, **more))
    result = make.rendered(offset(snapshot, 0.7), 8, samples=64, max_depth=4)
    mean, error = mean_and_error(result)
    assert (mean <= 1 + 4.5 * error).all()
    if kind == "BsdfTranslucent":  # what passes is left alone
        assert_within_standard_errors(result, 1.0)
    else:
        assert (mean < make.rendered(snapshot, 8, samples=16, max_depth=4).image()[..., :3].mean()).all()


def test_the_factor_lies_between_0_and_1():
    cosine, f = (x.ravel().astype(np.float32) for x in np.meshgrid(np.linspace(-1, 1.0001, 999), [1, 1.3, 2]))
    factor = fade(cosine, f)
    assert np.isfinite(factor).all()
    assert factor.min() >= 0
    assert factor.max() <= 1
    assert (factor[f == 1] == 1).all()
    kept = (cosine > 0.1) & (cosine < 1)
    expected = np.maximum(np.cos(np.arccos(np.minimum(cosine, 1)) * f), 0) / cosine
    np.testing.assert_allclose(factor[kept], expected[kept], atol=2e-5)
    assert (factor[cosine < 0] == 1).all()


@pytest.mark.parametrize("material", [ROUGH, make.diffuse(0.7)], ids=["rough", "diffuse"])
def test_three_strategies_agree(material):
    snapshot = offset(room(material, SOFT_LAMP), 0.8)
    a, b, c = (
        make.rendered(snapshot, 16, samples=64, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    )
    assert_same_mean(a, c)
    assert_same_mean(b, c)
    assert np.mean(c.image()[..., :3]) < 0.95 * np.mean(
        make.rendered(offset(snapshot, 0.0), 16, samples=16, integrator="direct_mis").image()[..., :3]
    )


def test_without_it_nothing_is_kept():
    assert prepare(offset(plane(make.diffuse(1.0)), 0.0)).light_angles is None
