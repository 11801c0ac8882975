"""Bad samples are named where the scene moves, is seen twice, has strands, or is a shadow catcher's."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.faults import GLOSSY, poisoned, snapshot, told, with_bsdf
from support.motion import moving
from support.strands import among, strand

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Stereo, Visibility

pytestmark = pytest.mark.filterwarnings("ignore:invalid value")
WRONG = poisoned("sample", np.nan, lambda u: u < 1 / 30)


def assert_brass(found, owner):
    """All of a render's bad samples are the brass's, on some object."""
    assert found["count"] > 0
    assert found["samples"]
    for sample in found["samples"]:
        assert (sample["material"], sample["object"]) == ("brass", owner), sample
        assert sample["what"] == "BSDF sample: weight"


def test_in_the_moment_that_the_sample_saw():
    """A ball that crosses the picture: a replay at another moment would not meet it."""
    still = snapshot()
    path = [make.translation(x, 0, 0) @ still.instances.matrix[1] for x in (-1.5, 0, 1.5)]
    assert_brass(told(with_bsdf(WRONG, prepare(moving(still, {1: path})))), "object 1")


def test_through_either_eye():
    """Of spherical stereo, which moves the origin of each ray."""
    still = snapshot()
    for offset in (-0.3, 0.3):
        eye = replace(still.camera, stereo=Stereo(offset, 3.0))
        assert_brass(told(with_bsdf(WRONG, prepare(replace(still, camera=eye)))), "object 1")


def test_on_a_strand():
    hair = strand([(-1, 0, 0.2), (0, 0.2, 0.9), (1, 0, 0.2)], 0.2)
    scene = make.scene(
        [(make.quad(0.1), make.translation(0, 0, -3), GLOSSY)],
        make.perspective((0, -4, 1), (0, 0, 0.4), 0.35),
        sky=make.world(0.5),
    )
    assert_brass(told(with_bsdf(WRONG, prepare(among(scene, [hair])))), "round 0")


def caught():
    """The floor is a shadow catcher under a sky."""
    base = snapshot()
    visibility = base.instances.visibility.copy()
    visibility[0] |= Visibility.CATCHER
    return prepare(replace(base, instances=replace(base.instances, visibility=visibility)))


def test_on_what_stands_on_a_shadow_catcher():
    assert_brass(told(with_bsdf(WRONG, caught())), "object 1")


def test_among_catchers_alone():
    """Where the second path of a catcher's sample is at fault: counted, dropped and named, too."""
    scene = caught()
    assert told(scene)["count"] == 0
    scene.alone.world = replace_constant(scene.alone.world, np.inf)
    found = told(scene)
    assert found["count"] > 0
    assert {sample["what"] for sample in found["samples"]} == {"found an emitter: Le"}
    assert {sample["material"] for sample in found["samples"]} == {"sky"}


def replace_constant(world, value):
    """A copy of a world that shines `value`."""
    other = copy.copy(world)
    other.constant = np.array([1, value, 1], np.float32)
    return other
