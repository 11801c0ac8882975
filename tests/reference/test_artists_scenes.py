"""The 20 artists' files through the command line, against the Cycles pair beside each.

All must open, render finite and say what they can't do; those marked `matches` must look like Cycles
within noise or 3 % beyond it. `docs/references.md` lists all with causes.
"""

import numpy as np
import pytest

pytest.importorskip("bpy")

from support.artists import CASES
from support.references import outcome
from support.shared_scenes import folder_or_skip

TOLERANCE = 0.03


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_renders_and_agrees(case):
    samples = max(8, case.samples // 2)  # the z-test knows what noise that leaves; docs/references.md has all
    found = outcome(case, folder_or_skip("scenes"), samples)
    assert all(np.isfinite(image).all() for image in found.images)
    assert found.statistics["nonfinite"]["count"] == 0
    assert found.images[0][..., :3].max() > 0
    if case.matches or not found.gaps:
        assert found.agreement.agrees(TOLERANCE), str(found.agreement)
    else:
        assert found.agreement.error < TOLERANCE or case.cause, str(found.agreement)
