"""Rows exposed one after the other: a moving edge is slanted, each row's blur as short as its time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving, standing_at

from pt_engine.scene.snapshot import LightData, Visibility

SIZE = 12
QUADRATURE = (np.arange(64) + 0.5) / 64


def rolling(snapshot, exposure):
    return replace(snapshot, motion=replace(snapshot.motion, row_exposure=exposure))


def crossing(exposure):
    """A shining half plane, its edge at x = t − ½ at time t in [0, 1], in an image 4 wide seen from above."""
    wall = make.mesh([(-9, -9, 0), (0, -9, 0), (0, 9, 0), (-9, 9, 0)], [(0, 1, 2), (0, 2, 3)])
    snapshot = make.scene(
        [(wall, np.eye(4), make.emission(1.0))], make.orthographic((0, 0, 5), (0, 0, 0), 4.0)
    )
    return rolling(moving(snapshot, {0: [make.translation(x, 0, 0) for x in (-0.5, 0.5)]}), exposure)


@pytest.mark.parametrize("exposure", [0.0, 0.3, 1.0])
def test_a_moving_edge_is_slanted(exposure):
    """Row y sees times d·s + (1 − d)(1 − y/h), s uniform: the wall covers x where x < t − ½."""
    result = make.rendered(crossing(exposure), SIZE, samples=64, sampler="sobol")
    x = (np.arange(SIZE)[:, None] + QUADRATURE) * 4 / SIZE - 2
    down = 1 - np.arange(SIZE) / SIZE
    first = (1 - exposure) * down - 0.5
    reached = (x[None] - first[:, None, None]) / max(exposure, 1e-9)
    expected = (1 - np.clip(reached, 0, 1)).mean(axis=2)
    found = result.image()[..., 0]
    position = found.sum(axis=1) * 4 / SIZE - 2
    np.testing.assert_allclose(position, first + exposure / 2, atol=0.05)
    # the eight times of a row make its spread less by 1/8 of it at most
    assert spread(found) == pytest.approx(spread(expected), rel=0.2)


def spread(rows):
    """How far the edge is from sharp: of a ramp that is w pixels wide, w/6."""
    return (rows * (1 - rows)).sum(axis=1).mean()


def catching():
    """A ball and the floor that catches its shadow go different ways under a lamp and a grey sky."""
    lamp = LightData("AREA", "lamp", make.looking((1, -1, 4), (0, 0, 0)), 80.0, size=(1.0, 1.0))
    floor = make.quad(3.0), np.eye(4), make.diffuse(0.6, "floor")
    ball = make.sphere(0.4, 8), make.translation(0, 0, 0.5), make.diffuse(0.4, "ball")
    # so that the scene has the same size at all times, by which lights are chosen
    ends = [(s * 6 + a, s * 6 + b, s * 6) for s in (-1, 1) for a, b in ((0, 0), (0, 0.01), (0.01, 0))]
    frame = make.mesh(ends, [(0, 1, 2), (3, 4, 5)]), np.eye(4), make.diffuse(0.5, "frame")
    camera = make.perspective((0, -5, 3), (0, 0, 0), 0.4)
    made = make.scene([floor, ball, frame], camera, [lamp], make.world(0.3))
    seen = made.instances.visibility.copy()
    seen[0] |= Visibility.CATCHER
    made = replace(made, instances=replace(made.instances, visibility=seen))
    paths = {
        0: [make.translation(0, 0, z) for z in (-0.8, 0.4)],
        1: [make.translation(x, 0, 1) for x in (-1, 1)],
    }
    return moving(made, paths)


@pytest.mark.parametrize("clear", [False, True])
def test_each_row_is_that_of_the_still_scene_at_its_time(clear):
    """With no exposure at all a row sees one moment; so does what it takes from catchers alone."""
    snapshot, rows = catching(), 4
    settings = {"samples": 16, "max_depth": 4, "film_transparent": clear}
    found = make.rendered(rolling(snapshot, 0.0), (12, rows), **settings).image()
    for y in range(rows):
        expected = make.rendered(standing_at(snapshot, 1 - y / rows), (12, rows), **settings).image()
        np.testing.assert_allclose(found[y], expected[y], rtol=2e-3, atol=1e-4)
        other = make.rendered(standing_at(snapshot, y / rows), (12, rows), **settings).image()
        # the lowest row sees little but sky at any time
        assert y == rows // 2 or np.abs(found[y] - other[y]).max() > 0.003


def test_the_cut_of_the_work_changes_no_bit():
    snapshot = crossing(0.3)
    images = [
        make.rendered(snapshot, (13, 9), samples=6, lanes=lanes, threads=threads).image()
        for lanes, threads in ((1 << 16, 1), (40, 2))
    ]
    np.testing.assert_array_equal(*images)
    part = make.rendered(snapshot, (13, 9), samples=6, border=(2, 3, 11, 8)).image()
    np.testing.assert_array_equal(part, images[0][3:8, 2:11])
