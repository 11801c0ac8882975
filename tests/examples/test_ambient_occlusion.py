"""The documented example of a user's integrator: it loads as a plugin and its integral is right."""

from pathlib import Path

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_within_standard_errors

from pt_engine.blender import plugins
from pt_engine.render.integrator import INTEGRATORS

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "ambient_occlusion.py"
REACH = 1.0


@pytest.fixture
def _loaded():
    before = dict(INTEGRATORS)
    assert plugins.load(EXAMPLE) == ["ambient_occlusion"]
    yield
    INTEGRATORS.clear()
    INTEGRATORS.update(before)


def floor_beside_a_wall(distance: float):
    """A tiny patch of a floor, seen from above, with an endless wall at x = `distance`."""
    wall = np.array([[0, 0, -1, distance], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]], float)
    square, grey = make.quad(200.0), make.diffuse(0.5)
    camera = make.orthographic((0, 0, 50.0), (0, 0, 0), 1e-3)
    return make.scene([(square, np.eye(4), grey), (square, wall, grey)], camera)


@pytest.mark.usefixtures("_loaded")
@pytest.mark.parametrize("distance", [0.05, 0.5, 0.9, 1.1])
def test_openness_of_a_floor_beside_a_wall(distance):
    """The wall is met within reach R where ω_x ≥ a = d/R: of the unit disk that ω projects onto, a segment.

    A = 1 − (arccos a − a √(1 − a²)) / π
    """
    a = min(distance / REACH, 1.0)
    expected = 1 - (np.arccos(a) - a * np.sqrt(1 - a * a)) / np.pi
    result = make.rendered(
        floor_beside_a_wall(distance), 8, samples=256, integrator="ambient_occlusion"
    )  # the patch is 0.001 wide: its mean differs by less than 1e-6
    assert_within_standard_errors(result, expected, relative=1e-5)


def test_the_documentation_shows_the_very_file():
    text = (ROOT / "docs" / "writing-an-integrator.md").read_text(encoding="utf-8")
    assert EXAMPLE.read_text(encoding="utf-8") in text
