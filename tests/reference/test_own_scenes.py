"""Scenes of the project's own, each about one thing, against the Cycles of the bpy wheel."""

import pytest

pytest.importorskip("bpy")

from reference.own_scenes import SCENES
from support.cycles import by_cycles, by_engine
from support.ztest import compare

pytestmark = pytest.mark.slow  # physics that no Python changes

SIZE = (64, 48)
SAMPLES = 64
TOLERANCE = 0.01  # RMS over cells beyond noise; a scene fails only if the noise can't explain it either
KNOWN = {"principled-sheen": 0.03}  # what coverage calls approximate may be further away


@pytest.mark.parametrize("name", SCENES)
def test_agrees_with_cycles(name, tmp_path):
    SCENES[name]()
    agreement = compare(by_engine(SAMPLES, SIZE), by_cycles(SAMPLES, SIZE, tmp_path), grid=(8, 6))
    assert agreement.agrees(KNOWN.get(name, TOLERANCE)), str(agreement)
