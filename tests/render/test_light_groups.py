"""Light groups: shares of the picture that sum to it, each what its emitters would send alone."""

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import mean_and_error
from support.motion import moving
from support.rooms import GLASS, ROUGH, SOFT_LAMP, half_transparent, room

from pt_engine.core.samplers import SAMPLERS
from pt_engine.render.film import Film
from pt_engine.render.group_films import GroupFilms
from pt_engine.render.integrator import INTEGRATORS
from pt_engine.render.schedule import Unit
from pt_engine.render.settings import RenderSettings
from pt_engine.render.worker import Worker
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Visibility

SKY = make.world((0.3, 0.4, 0.6))
GLOW = (make.quad(0.8), make.translation(-0.9, 0.4, 2.4), make.emission((6.0, 5.0, 4.0), "glow"))
TWO, NAMES = 2, ("lamp", "glow", "sky")


def lit(material=ROUGH, sky=SKY, glow=GLOW, lamps=1, **more):
    """A room under a lamp that is seen, a shining quad and a sky, each a group of its own."""
    snapshot = room(material, replace(SOFT_LAMP, visibility=Visibility.ALL), sky)
    placed = [
        (snapshot.meshes[m], matrix, snapshot.materials[k[0]])
        for m, matrix, k in zip(
            snapshot.instances.mesh, snapshot.instances.matrix, snapshot.instances.materials, strict=True
        )
    ]
    lamp = replace(snapshot.lights[0], light_group=1)
    made = make.scene([*placed, *([glow] if glow else [])], snapshot.camera, [lamp] * lamps, sky)
    group = np.zeros(len(made.instances.mesh), np.int32)
    group[len(placed) :] = TWO
    made = replace(made, instances=replace(made.instances, light_group=group))
    return replace(made, light_groups=NAMES, world_light_group=3, **more)


def shares(result):
    return np.stack([result.light_group(name) for name in NAMES])


@pytest.mark.parametrize("integrator", [name for name in INTEGRATORS if name != "normals"])
@pytest.mark.parametrize("material", [ROUGH, half_transparent(0.5)], ids=["rough", "veil"])
def test_groups_sum_to_the_picture(integrator, material):
    result = make.rendered(lit(material), (16, 12), samples=4, integrator=integrator)
    np.testing.assert_allclose(shares(result).sum(0), result.image()[..., :3], rtol=2e-6, atol=1e-6)
    assert (shares(result).max(axis=(1, 2, 3)) > 0.01).all()


def test_what_is_clamped_is_clamped_in_its_group():
    settings = {"samples": 4, "clamp_direct": 0.2, "clamp_indirect": 0.1}
    result = make.rendered(lit(), 12, **settings)
    np.testing.assert_allclose(shares(result).sum(0), result.image()[..., :3], rtol=2e-6, atol=1e-6)
    assert result.image()[..., :3].mean() < 0.9 * make.rendered(lit(), 12, samples=4).image()[..., :3].mean()


def test_what_is_in_no_group_is_the_rest():
    """With the sky in none, the two others sum to the picture less the sky's own."""
    groups = make.rendered(lit(), 12, samples=4)
    others = make.rendered(replace(lit(), world_light_group=0), 12, samples=4)
    assert not others.light_group("sky").any()
    for name in NAMES[:2]:
        np.testing.assert_array_equal(others.light_group(name), groups.light_group(name))


@pytest.mark.parametrize("lamps", [1, 20], ids=["one lamp", "a crowd, chosen by place"])
def test_each_is_what_its_emitters_send_alone(lamps):
    """Against renders that hold no other light, by their standard errors."""
    whole = make.rendered(lit(GLASS, lamps=lamps), 12, samples=32)
    dark = make.world((0.0, 0.0, 0.0))
    alone = {
        "lamp": lit(GLASS, sky=dark, glow=None, lamps=lamps),
        "glow": lit(GLASS, sky=dark, lamps=0),
        "sky": lit(GLASS, glow=None, lamps=0),
    }
    for name, snapshot in alone.items():
        expected, error = mean_and_error(make.rendered(without_groups(snapshot), 12, samples=32, seed=1))
        film = whole.progress.groups.films[name]
        found = film.image()[..., :3].astype(np.float64).reshape(-1, 3).mean(0)
        noise = np.sqrt(film.variance_of_mean().reshape(-1, 3).sum(0)) / film.pixels
        assert (np.abs(found - expected) <= 4.5 * np.hypot(error, noise)).all(), (name, found, expected)


def without_groups(snapshot):
    lamps = tuple(replace(lamp, light_group=0) for lamp in snapshot.lights)
    rows = replace(snapshot.instances, light_group=None)
    return replace(snapshot, light_groups=(), world_light_group=0, lights=lamps, instances=rows)


def test_neither_the_groups_nor_the_cut_of_the_work_changes_a_bit():
    snapshot, plain = lit(), without_groups(lit())
    cuts = ((1 << 16, 1), (50, 2))
    a, b = (make.rendered(snapshot, (13, 9), samples=4, lanes=n, threads=k) for n, k in cuts)
    np.testing.assert_array_equal(shares(a), shares(b))
    np.testing.assert_array_equal(a.image(), make.rendered(plain, (13, 9), samples=4).image())
    assert prepare(plain).for_unit(8).by_group is None


def test_parts_of_a_render_merge():
    snapshot = lit()
    whole, first = (make.rendered(snapshot, 9, samples=n).progress.groups.films for n in (5, 2))
    second = make.rendered(snapshot, 9, samples=3, first_sample=2).progress.groups.films
    for name in NAMES:
        first[name].merge(second[name])
        np.testing.assert_array_equal(first[name].image(), whole[name].image())


def test_what_the_film_drops_is_dropped_of_every_share():
    """One of four samples is not finite in one group: all films keep the other three."""
    film = Film(1, 1)
    groups = GroupFilms(film, np.arange(1, dtype=np.int32), ("a", "b"))
    parts = np.ones((3, 3, 4), np.float32)
    parts[:, 1, 2] = np.nan
    refused = film.add(np.array([0]), 0, 4, parts.sum(axis=1))
    groups.add(np.array([0]), 0, 4, parts, refused)
    assert film.image()[0, 0, 0] == 3
    for name in "ab":
        assert groups.image(name)[0, 0, 0] == 1
        assert groups.films[name].counts()[0, 0] == 3


def test_shares_of_units_that_see_several_moments_are_those_of_each():
    snapshot = moving(lit(), {2: [make.translation(x, 0.3, 0.7) for x in (-0.5, 0.5)]})
    settings = RenderSettings(8, 6, samples=4, threads=1, max_depth=4)
    worker = Worker(prepare(snapshot), settings, INTEGRATORS["path"](settings), SAMPLERS["sobol"](0))
    pixels = np.arange(48, dtype=np.int32)
    together = worker.render(Unit(pixels, 0, 4)).by_group.reshape(3, len(NAMES) + 1, 4, 48)
    for k in range(4):
        np.testing.assert_array_equal(together[:, :, k], worker.render(Unit(pixels, k, 1)).by_group)
    assert (together.max(axis=(0, 2, 3))[1:] > 0).all()
