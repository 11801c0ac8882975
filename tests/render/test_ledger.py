"""The ledger: times that add up, what each bounce, effect and material took, and what keeping it costs."""

from __future__ import annotations

import time
from collections import defaultdict
from itertools import pairwise

import numpy as np
import pytest
from support import scenes as make
from support import strands
from support.rooms import MIRROR, SOFT_LAMP, half_transparent, room

from pt_engine.blender.words import ledger_lines
from pt_engine.core import clock
from pt_engine.core.clock import Clock, runs, stage
from pt_engine.render.ledger import STAGES, Ledger, whole
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare


def kept(snapshot, size=64, **more):
    """The books of a render, its result, and the CPU seconds that the whole call took."""
    scene, ledger = prepare(snapshot), Ledger()
    settings = RenderSettings(size, size, **{"samples": 8, "threads": 1, "max_depth": 5, **more})
    render(scene, settings)  # what is made at the first render
    started = clock.now()
    result = render(scene, settings, ledger=ledger)
    return ledger.books(scene), result, clock.now() - started


@pytest.fixture(scope="module")
def books_of_a_room():
    return kept(room(make.diffuse(0.5), SOFT_LAMP), size=128, samples=32)


def test_stages_add_up_to_the_render(books_of_a_room):
    """Σ stages is the thread's time within 3 %: what is left is between the call and the first unit."""
    books, _, cpu = books_of_a_room
    assert sum(stage["seconds"] for stage in books["stages"].values()) == pytest.approx(cpu, rel=0.03)


def test_stages_and_waiting_are_the_wall_time(books_of_a_room):
    books, result, _ = books_of_a_room
    total = sum(stage["seconds"] for stage in books["stages"].values()) + books["waiting"]
    assert total == pytest.approx(books["wall"] * books["threads"], rel=0.03)
    assert books["wall"] == pytest.approx(result.seconds, rel=0.03)


def test_two_threads_add_up_too():
    """The calling thread's film is a third thread's work, a few per cent."""
    books, result, _ = kept(room(make.diffuse(0.5), SOFT_LAMP), size=128, threads=2)
    total = sum(stage["seconds"] for stage in books["stages"].values()) + books["waiting"]
    assert total == pytest.approx(2 * result.seconds, rel=0.1)


def hair_under_a_sky():
    hair = strands.tuft(200, 5, 0.02, "THICK")
    return strands.snapshot([hair], material=make.diffuse(0.5), world=make.world(1.0))


def lens_and_sky():
    camera = make.perspective((0, 0, 5), (0, 0, 0), aperture_radius=0.1, focus_distance=5.0)
    return make.scene([(make.quad(4), np.eye(4), make.diffuse(0.5))], camera, sky=make.world(1.0))


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("made", [hair_under_a_sky, lens_and_sky])
def test_they_add_up_in_other_scenes(made, threads):
    """Within 3 % of the wall time; no stage's share is so wrong that they would exceed it."""
    books, result, _ = kept(made(), size=192, threads=threads)
    busy = sum(stage["seconds"] for stage in books["stages"].values())
    assert busy + books["waiting"] == pytest.approx(threads * result.seconds, rel=0.03)
    assert sum(bounce["seconds"] for bounce in books["bounces"]) < busy


def test_rays_are_those_of_the_render(books_of_a_room):
    books, result, _ = books_of_a_room
    rays = result.progress.rays
    assert books["stages"]["intersect"]["rays"] == rays["camera"] + rays["bounce"]
    assert books["stages"]["shadow"]["rays"] == rays["shadow"]
    assert sum(bounce["rays"] for bounce in books["bounces"]) == sum(rays.values())
    assert len(books["bounces"]) == 5


def test_every_stage_has_a_name(books_of_a_room):
    assert set(books_of_a_room[0]["stages"]) <= set(STAGES)


def test_later_bounces_have_no_more_rays(books_of_a_room):
    rays = [bounce["rays"] for bounce in books_of_a_room[0]["bounces"]]
    assert all(later <= earlier for earlier, later in pairwise(rays[1:]))


def test_a_scene_without_an_effect_says_why_it_cost_nothing(books_of_a_room):
    books = books_of_a_room[0]
    assert books["off"]["depth of field"] == "the camera has no aperture"
    assert "depth of field" not in books["effects"]


def test_an_effect_that_is_on_has_seconds():
    camera = make.perspective((0, 0, 5), (0, 0, 0), aperture_radius=0.1, focus_distance=5.0)
    snapshot = make.scene([(make.quad(4), np.eye(4), make.diffuse(0.5))], camera, sky=make.world(1.0))
    books, _, _ = kept(snapshot)
    assert books["effects"]["depth of field"]["seconds"] > 0
    assert books["effects"]["environment"]["seconds"] > 0
    assert "depth of field" not in books["off"]


def test_vertices_belong_to_their_materials():
    """An orthographic camera sees two quads of the same program, one of them half as wide."""
    left, right = make.translation(-1, 0, 0), make.translation(1.5, 0, 0)
    narrow = make.mesh([(-0.5, -1, 0), (0.5, -1, 0), (0.5, 1, 0), (-0.5, 1, 0)], [(0, 1, 2), (0, 2, 3)])
    objects = [
        (make.quad(2), left, make.diffuse(0.5, "wide")),
        (narrow, right, make.diffuse(0.4, "narrow")),
    ]
    snapshot = make.scene(objects, make.orthographic((0, 0, 3), (0, 0, 0), 4), sky=make.world(1.0))
    books, _, _ = kept(snapshot, pixel_filter="BOX", max_depth=2)
    materials = books["materials"]
    assert set(materials) == {"wide", "narrow"}
    assert materials["wide"]["vertices"] == pytest.approx(2 * materials["narrow"]["vertices"], rel=0.02)
    assert materials["wide"]["seconds"] == pytest.approx(2 * materials["narrow"]["seconds"], rel=0.02)


def test_rays_belong_to_the_materials_that_they_leave():
    """Under a lamp a matte vertex sends one ray toward it and one onward; a mirror's only goes on."""
    objects = [
        (make.quad(2), make.translation(-1, 0, 0), make.diffuse(0.5, "matte")),
        (make.quad(2), make.translation(1, 0, 0), MIRROR),
    ]
    snapshot = make.scene(objects, make.orthographic((0, 0, 3), (0, 0, 0), 4), [SOFT_LAMP])
    books, result, _ = kept(snapshot, pixel_filter="BOX", max_depth=2, samples=64)
    matte, ideal = books["materials"]["matte"], books["materials"]["mirror"]
    assert matte["rays"] == pytest.approx(2 * matte["vertices"], rel=0.02)
    assert ideal["rays"] == pytest.approx(ideal["vertices"], rel=0.02)
    sent = sum(row["rays"] for row in books["stages"].values()) - result.progress.camera_samples
    assert matte["rays"] + ideal["rays"] == pytest.approx(sent, rel=0.02)


def test_rays_belong_to_the_effect_that_asks_for_them():
    """Every shadow ray is one of transparent surfaces where there are such."""
    veil = (make.quad(4), make.translation(0, 0, 0.5), half_transparent(1.0))
    floor = (make.quad(4), np.eye(4), make.diffuse(0.5))
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 2)
    books, result, _ = kept(make.scene([floor, veil], camera, [SOFT_LAMP]), max_depth=2, samples=16)
    effect = books["effects"]["shadows of transparent surfaces"]
    assert effect["rays"] == pytest.approx(result.progress.rays["shadow"], rel=0.05)


def test_it_changes_no_bit():
    scene = prepare(room(make.diffuse(0.5), SOFT_LAMP))
    settings = RenderSettings(16, 16, samples=4, threads=2)
    np.testing.assert_array_equal(
        render(scene, settings).image(), render(scene, settings, ledger=Ledger()).image()
    )


def test_what_is_made_once_does_not_count_for_every_unit(monkeypatch):
    """100 s of tables in the first unit, a second of work in each: a twelfth is looked into."""
    at = [0.0]
    monkeypatch.setattr(clock, "now", lambda: at[0])

    def takes(seconds):
        at[0] += seconds

    tables, work = stage("random")(takes), stage("bsdf")(takes)

    @clock.unit_of_work
    def unit(number):
        if number == 0:
            tables(100)
        work(1)

    ledger = Ledger()
    with ledger.running():
        for number in range(60):
            unit(number)
    seconds = {cell.stage: part for cell, part in ledger.cells().items()}
    assert seconds["random"] == pytest.approx(100)
    assert seconds["bsdf"] == pytest.approx(60)


def test_few_units_tell_stages_and_not_what_is_between_them(monkeypatch):
    """3 s of work in each of five units, 1 s on no stage; 2 s between them are no unit's."""
    at = [0.0]
    monkeypatch.setattr(clock, "now", lambda: at[0])

    def takes(seconds):
        at[0] += seconds

    work = stage("bsdf")(takes)

    @clock.unit_of_work
    def unit():
        takes(1)
        work(3)

    ledger = Ledger()
    with ledger.running():
        for _ in range(5):
            unit()
            takes(2)
    seconds = defaultdict(float)
    for cell, part in ledger.cells().items():
        seconds[cell.stage] += part
    assert seconds == {"bsdf": pytest.approx(15), "rest": pytest.approx(5 * (1 + 2))}


def test_a_clock_too_coarse_to_see_a_stage_has_nothing_to_share_out():
    film, hidden = clock.Cell("film", "", -1, 0), clock.Cell(clock.UNTIMED, "", -1, 0)
    assert whole({film: 2.0, hidden: 1.0}, {}) == {film: 2.0}


def test_a_generator_counts_only_while_it_runs():
    @stage("inner")
    def numbers():
        for k in range(3):
            spend(0.02)
            yield k

    with runs(Clock("outer")) as kept_clock:
        for _ in numbers():
            spend(0.01)
    seconds = {cell.stage: part for cell, part in kept_clock.seconds.items()}
    assert seconds["inner"] == pytest.approx(0.06, rel=0.2)
    assert seconds["outer"] == pytest.approx(0.03, rel=0.2)


def spend(seconds):
    """Keep this thread busy."""
    end = clock.now() + seconds
    while clock.now() < end:
        pass


def test_keeping_it_costs_less_than_one_per_cent(monkeypatch):
    """Calls of a wavefront × what one costs, against the wavefront: a direct comparison drowns in noise."""

    @stage("probe")
    def nothing():
        pass

    def cost(calls=2000):
        started = time.thread_time()
        for _ in range(calls):
            nothing()
        return (time.thread_time() - started) / calls

    without = min(cost() for _ in range(5))
    with runs(Clock()):
        each = min(cost() for _ in range(5)) - without
    calls = 0
    enter = Clock.enter

    def counted(self, *words):
        nonlocal calls
        calls += 1
        enter(self, *words)

    monkeypatch.setattr(Clock, "enter", counted)
    books, result, _ = kept(room(make.diffuse(0.5), SOFT_LAMP), size=256, samples=4)
    assert result.progress.samples == 4
    assert calls * each < 0.01 * sum(stage["seconds"] for stage in books["stages"].values())


def test_lines_for_the_panel(books_of_a_room):
    lines = ledger_lines({"ledger": books_of_a_room[0]})
    assert lines[0].startswith("Time: ")
    told = [part.rpartition(" ")[0] for part in lines[0].removeprefix("Time: ").split(", ")]
    assert set(told) < set(STAGES.values())
    assert "%" in lines[1]
    assert ledger_lines({}) == []
