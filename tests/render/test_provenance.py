"""Bad samples are dropped, counted and named: faults are put into a scene, and found where they were put."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.faults import poisoned, settings, snapshot, told, with_bsdf

from pt_engine.render.integrator import INTEGRATORS, Integrator
from pt_engine.render.progressive import render
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_bsdf_that_samples_bad_weights_is_named(value):
    """A thirtieth of the lanes: each dropped sample names the brass, its object, and the BSDF's sample."""
    found = told(with_bsdf(poisoned("sample", value, lambda u: u < 1 / 30)))
    assert 0 < found["count"] < 12 * 8 * 16 / 10
    assert 0 < len(found["samples"]) <= 20
    for sample in found["samples"]:
        assert (sample["material"], sample["object"]) == ("brass", "object 1"), sample
        assert sample["what"] == "BSDF sample: weight"
        assert sample["bounce"] in (0, 1, 2)
    assert {s["bounce"] for s in found["samples"]} >= {0}


@pytest.mark.parametrize("value", [np.nan, -10.0])
def test_a_bsdf_that_evaluates_to_what_cannot_be_is_named(value):
    """The shadow ray is traced for such a value, too, and does not hide it."""
    found = told(with_bsdf(poisoned("eval", value, lambda x: np.abs(x) < 0.4)))
    assert found["count"] > 0
    for sample in found["samples"]:
        assert sample["material"] == "brass"
        assert sample["what"] == "BSDF toward the emitter: f·cosθ"


@pytest.mark.parametrize("value", [np.inf, np.nan, -3.0])
def test_a_surface_that_shines_what_cannot_be_is_named(value):
    """Put in after the scene was prepared, so that the engine has no reason to expect a negative light."""
    scene = prepare(snapshot())
    row = scene.material_names.index("tube")
    before = scene.materials.emission_constant.copy()
    scene.materials.emission_constant[row] = value
    if value < 0:
        scene.materials.emission_constant = Bright(scene.materials.emission_constant, before)
    found = told(scene)
    assert found["count"] > 0
    for sample in found["samples"]:
        assert (sample["material"], sample["object"]) == ("tube", "object 2"), sample
        assert sample["what"] == "found an emitter: Le"


class Bright:
    """An emission table that looks sound to whoever asks for all of it."""

    def __init__(self, table, sound):
        self.table, self.sound = table, sound

    def __getitem__(self, rows):
        return self.sound[rows]

    def take(self, rows, axis):
        return self.table.take(rows, axis=axis)


def test_a_sky_that_is_not_finite_is_named():
    scene = prepare(snapshot())
    scene.world.constant = np.array([1, np.inf, 1], np.float32)
    found = told(scene)
    assert {s["material"] for s in found["samples"]} == {"sky"}
    assert {s["what"] for s in found["samples"]} == {"found an emitter: Le"}


def test_negative_light_is_no_fault():
    """A lamp or a surface that takes light away makes samples below 0, which are kept."""
    lamp = LightData("POINT", "thief", make.translation(0, -1, 2), -500.0)
    for scene in (prepare(snapshot([lamp])), prepare(snapshot(sky=-0.5))):
        how = settings()
        result = render(scene, how)
        assert result.progress.nonfinite_count == 0
        assert result.image()[..., :3].min() < 0


def test_a_lamp_whose_nodes_are_negative_is_no_fault():
    """Its light is its normal, each of whose coordinates is negative somewhere."""
    nodes = Node("NewGeometry", "g"), Node("Emission", "e", {"Color": Link(0, "Normal"), "Strength": 1.0})
    graph = Graph("g", nodes, {"Surface": Link(1, "Emission")})
    lamp = LightData("POINT", "odd", make.translation(0, -1, 2), 500.0, radius=0.5, graph=graph)
    result = render(prepare(snapshot([lamp])), settings())
    assert result.progress.nonfinite_count == 0
    assert result.image()[..., :3].min() < 0


class Signed(Integrator):
    """−1 everywhere."""

    def sample(self, scene, rays, sampler):
        return np.full(rays.o.shape, -1, np.float32)


class Breaks(Signed):
    """Fails on a single lane."""

    def sample(self, scene, rays, sampler):
        if rays.o.shape[1] == 1:
            raise ValueError("one lane is too few")
        return super().sample(scene, rays, sampler)


def test_an_integrator_may_be_signed(monkeypatch):
    """What it says below 0 is dropped unless it says that it may; a replay that fails costs nothing."""
    monkeypatch.setitem(INTEGRATORS, "minus", Signed)
    monkeypatch.setitem(INTEGRATORS, "breaks", Breaks)
    scene = prepare(snapshot())
    found = told(scene, integrator="minus")
    assert found["count"] == 12 * 8 * 16
    assert {s["what"] for s in found["samples"]} == {"the integrator's own arithmetic"}
    assert "one lane is too few" in told(scene, integrator="breaks")["samples"][0]["what"]
    monkeypatch.setattr(Signed, "signed", True)
    assert told(scene, integrator="minus") == {"count": 0, "samples": []}


def test_a_sound_scene_reports_nothing():
    assert told(prepare(snapshot())) == {"count": 0, "samples": []}
