"""Integrators by name: the lecture's ladder, and whatever a user's file adds."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make

from pt_engine.render import integrators  # noqa: F401  (fills the registry)
from pt_engine.render.integrator import INTEGRATORS, Integrator
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

LADDER = ["normals", "direct_bsdf", "direct_emitter", "direct_mis", "path_fixed", "path", "path_active"]


pytestmark = pytest.mark.usefixtures("own_integrators")


def test_the_ladder_is_there_in_its_order():
    """Normals first, then direct light three ways, fixed depth, and the whole path tracer."""
    order = [name for name in INTEGRATORS if name in LADDER]
    assert order[:5] == LADDER[:5]
    assert set(order[5:]) == set(LADDER[5:])


@pytest.mark.parametrize("name", LADDER)
def test_each_rung_can_be_shown_in_a_panel(name):
    rung = INTEGRATORS[name]
    assert rung.name == name
    assert rung.label
    assert len(rung.description) > 20
    assert len({INTEGRATORS[other].label for other in LADDER}) == len(LADDER)


def test_a_users_class_registers_by_its_name():
    class Distance(Integrator):
        name, label = "test_distance", "Distance"

        def sample(self, scene, rays, sampler):
            found = scene.intersect(rays)
            return np.where(found.hits.prim >= 0, found.hits.t, 0) * np.ones((3, 1), np.float32)

    assert INTEGRATORS["test_distance"] is Distance
    square = (make.quad(9.0), np.eye(4), make.diffuse(0.5))
    snapshot = make.scene([square], make.orthographic((0, 0, 3), (0, 0, 0), 1.0))
    image = make.rendered(snapshot, 4, samples=2, integrator="test_distance").image()
    np.testing.assert_allclose(image[..., :3], 3, rtol=1e-3)  # the near clip of 10⁻⁴ moves the rays' origins


def test_a_subclass_without_a_name_of_its_own_is_no_entry():
    """A base class of one's own, or a variation that inherits its parent's name."""

    class Base(Integrator):
        def sample(self, scene, rays, sampler):
            return np.zeros((3, rays.o.shape[1]), np.float32)

    class Variation(INTEGRATORS["path"]):
        pass

    assert Base not in INTEGRATORS.values()
    assert Variation not in INTEGRATORS.values()
    assert INTEGRATORS["path"].__name__ == "Path"


def test_an_integrator_needs_a_sample_method():
    class Nothing(Integrator):
        name = "test_nothing"

    with pytest.raises(TypeError, match="sample"):
        Nothing(RenderSettings(1, 1))


def test_an_unknown_name_is_a_key_error():
    square = (make.quad(), np.eye(4), make.diffuse(0.5))
    with pytest.raises(KeyError, match="bidirectional"):
        make.rendered(
            make.scene([square], make.orthographic((0, 0, 3), (0, 0, 0), 1.0)), 2, integrator="bidirectional"
        )


def test_depths_reach_the_integrator():
    how = RenderSettings(1, 1, max_depth=5, rr_depth=3, transparent_depth=2)
    path = INTEGRATORS["path"](how)
    assert (path.max_depth, path.rr_depth, path.transparent_depth) == (5, 3, 2)


def test_normals_are_colours():
    """(n + 1)/2 on the viewer's side, black beside it."""
    objects = [(make.quad(1.0), np.eye(4), make.diffuse(0.5))]
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 2.0)
    image = make.rendered(make.scene(objects, camera), 8, samples=2, integrator="normals").image()
    np.testing.assert_allclose(image[3:5, 3:5, :3], np.broadcast_to((0.5, 0.5, 1.0), (2, 2, 3)))
    assert (image[0, :, :3] == 0).all()
    ball = prepare(make.scene([(make.sphere(0.5, 64), np.eye(4), make.diffuse(0.5))], camera))
    assert ball.normals is not None
