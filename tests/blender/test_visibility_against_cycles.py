"""Who sees whom: ray visibility, holdouts, overrides, links. Each case is a change of one small room.

Both renderers' pictures have to agree, colour and alpha, within their noise.
"""

import numpy as np
import pytest

pytest.importorskip("bpy")
from support import ztest
from support.cycles import by_cycles, by_engine
from support.seen_room import CASES, room

pytestmark = pytest.mark.slow  # physics that no Python changes

SIZE, SAMPLES, CELLS = (36, 24), 64, (6, 4)
QUICK = {
    "cube unseen by camera",
    "box unseen by all but shadows",
    "lamp unseen by glossy",
    "shining cube unseen by diffuse",
    "world unseen by glossy",
    "veil held out",
    "clear film behind rough glass",
    "sun for 1 bounces",
    "lamp on floor but not on cube",
    "many lamps on some",
    "lamp not shaded by cube",
    "floor catches shadows on a clear film",
}
# What stops no shadow rays shines through itself with its far sides. BSDF samples never see these, so they
# count as much as their share among the sampled emitters: 1.289 with the sky among them, 1.314 without.
LOOSE = {"shining cube unseen by shadow": 0.03}
ALL = [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in CASES]


@pytest.mark.parametrize("name", ALL)
def test_the_room_looks_as_in_cycles(name, tmp_path):
    scene = room()
    CASES[name](scene)
    theirs, ours = by_cycles(SAMPLES, SIZE, tmp_path), by_engine(SAMPLES, SIZE)
    found = ztest.compare(ours, theirs, CELLS)
    assert found.agrees(tolerance=LOOSE.get(name, 0.01)), f"{name}: {found}"
    assert np.isfinite(ours[0]).all()
