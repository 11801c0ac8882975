"""Lights are chosen by place also where instances share their triangles: the choice knows their boxes."""

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene import instancing
from pt_engine.scene.prepare import prepare

GREY, COUNT = make.diffuse(0.5), 16
WIDE = 1.1 * COUNT
CAMERA = replace(make.orthographic((0, -30, 0), (0, 0, 0), 1), frame=(-WIDE, WIDE, -1.0, 1.0))
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


@pytest.fixture(name="row", scope="module")
def _row():
    """Balls in a row, which share a mesh, and over each a panel of its own brightness, sharing one too."""
    ball, panel = make.sphere(1.0, 8), make.quad(0.6)
    at = [2.2 * (k - (COUNT - 1) / 2) for k in range(COUNT)]
    objects = [(ball, make.translation(x, 0, 0), GREY) for x in at]
    glow = [make.emission(1.0 + k % 5, f"glow {k}") for k in range(COUNT)]
    objects += [(panel, make.translation(x, 0, 1.5) @ DOWN, g) for x, g in zip(at, glow, strict=True)]
    snapshot = make.scene(objects, CAMERA)
    which = np.repeat(np.int32([0, 1]), COUNT)
    snapshot = replace(snapshot, meshes=(ball, panel), instances=replace(snapshot.instances, mesh=which))
    plain = prepare(snapshot)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(instancing, "MANY", 0)
        shared = prepare(snapshot)
    assert plain.geometry.shared is None
    assert shared.geometry.shared is not None
    return plain, shared


def measured(scene, integrator, samples):
    """Mean radiance of four seeds, its standard error, and the mean variance of a pixel."""
    settings = RenderSettings(
        64, 4, samples=samples, integrator=integrator, sampler="independent", threads=1, pixel_filter="BOX"
    )
    images = [render(scene, replace(settings, seed=seed)).image()[..., 0] for seed in range(4)]
    means = [image.mean(dtype=np.float64) for image in images]
    return np.mean(means), np.std(means, ddof=1) / 2, np.var(images, axis=0, ddof=1).mean()


def test_three_estimators_agree_on_shared_instances(row):
    """And with the plain scene, within 5 standard errors; a shadow ray ends before its panel."""
    plain, shared = row
    expected, error, _ = measured(plain, "direct_mis", 96)
    for name in ("direct_bsdf", "direct_emitter", "direct_mis"):
        mean, own, _ = measured(shared, name, 96)
        assert abs(mean - expected) < 5 * np.hypot(own, error), name
        assert own < 0.06 * mean, name


def test_variance_is_that_of_plain_meshes_not_that_of_the_choice_by_power(row):
    _, shared = row
    of_plain, of_shared = (measured(scene, "direct_emitter", 64)[2] for scene in row)
    by_place, shared.lights.by_place = shared.lights.by_place, None
    by_power = measured(shared, "direct_emitter", 64)[2]
    shared.lights.by_place = by_place
    assert of_shared < 1.5 * of_plain
    assert of_shared < 0.5 * by_power
