"""Many emitters, chosen by place: the strategies still agree, behind transparent sheets too."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean, mean_and_error
from support.rooms import ROUGH, UP, half_transparent, rotation_x

from pt_engine.emitters import many
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData


def lit_room(material, sheet=None, lamps=True, faces=True):
    """Floor and wall, lit by two dozen squares of different power close to them, and as many spheres."""
    rng = np.random.default_rng(1)
    objects = [
        (make.quad(4.0), UP, make.diffuse(0.6, "floor")),
        (make.quad(4.0), make.translation(0, 2, 2) @ rotation_x(np.pi / 2), material),
    ]
    for k in range(24 if faces else 0):
        place = make.translation(*rng.uniform((-1.5, -1.5, 0.3), (1.5, 1.5, 1.5)))
        glow = make.emission(float(1 + 40 * (k % 4 == 0)), f"glow {k % 4 == 0}")
        objects.append((make.quad(0.25), place @ rotation_x(rng.uniform(0, 3)), glow))
    if sheet is not None:
        objects.append((make.quad(4.0), make.translation(0, 0, 0.2), sheet))
    spheres = [
        LightData(
            "POINT",
            "ball",
            make.translation(*rng.uniform((-1.5, -1.5, 0.3), (1.5, 1.5, 1.5))),
            w,
            radius=0.15,
        )
        for w in (rng.exponential(2.0, 40) if lamps else ())
    ]
    return make.scene(objects, make.perspective((0, -5, 2.6), (0, 0, 0.4), 0.35), spheres, make.world(0.1))


@pytest.mark.parametrize("what", ["lamps and faces", "faces", "lamps"])
def test_three_strategies_agree(what):
    snapshot = lit_room(ROUGH, lamps="lamps" in what, faces="faces" in what)
    scene = prepare(snapshot)
    assert scene.features["light choice by place"] == "on"
    results = {
        name: make.rendered(snapshot, 24, samples=96, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis", "path"))
    }
    assert_same_mean(results["direct_bsdf"], results["direct_mis"])
    assert_same_mean(results["direct_emitter"], results["direct_mis"])


@pytest.mark.parametrize("integrator", ["path", "path_fixed"])
def test_density_is_that_of_the_last_bounce_behind_a_sheet(integrator, monkeypatch):
    """A path passes a veil and meets a lamp: its MIS weight asks for where it came from, not for the veil."""
    snapshot = lit_room(make.diffuse(0.6, "wall"), half_transparent(0.7))
    more = {"samples": 160, "integrator": integrator, "max_depth": 3, "transparent_depth": 4}
    by_place = make.rendered(snapshot, 24, seed=1, **more)
    monkeypatch.setattr(many, "MANY", 10**6)
    assert_same_mean(by_place, make.rendered(snapshot, 24, seed=2, **more))


def test_choice_by_place_changes_the_noise_and_not_the_picture(monkeypatch):
    """A third of the variance, here where all lamps are near; they are not seen by the camera."""
    snapshot = lit_room(make.diffuse(0.6, "wall"), faces=False)
    by_place = make.rendered(snapshot, 24, samples=64, integrator="direct_mis", seed=1)
    monkeypatch.setattr(many, "MANY", 10**6)
    by_power = make.rendered(snapshot, 24, samples=64, integrator="direct_mis", seed=2)
    assert_same_mean(by_place, by_power)
    assert 3 * mean_and_error(by_place)[1].mean() ** 2 < mean_and_error(by_power)[1].mean() ** 2
