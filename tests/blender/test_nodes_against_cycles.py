"""Node by node, our programs give what Cycles gives (the Cycles inside bpy), whatever the inputs.

The questions are enumerated from this Blender (`support.parity`): here each value of a setting once with
each value of another; `python -m bench.parity` asks all combinations. A node may say in the coverage
that it is not exact; one that says it is must be.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.parity import cases, measure  # noqa: E402

from pt_engine.nodes import catalogue  # noqa: E402, F401  (fills the registry)
from pt_engine.nodes.coverage import EXACT  # noqa: E402
from pt_engine.nodes.registry import NODES  # noqa: E402

pytestmark = pytest.mark.skipif(
    bpy.app.version < (5, 0, 0),
    reason="the nodes follow Cycles 5: 4.5 hashes Voronoi's cells and rounds its colour matrices otherwise",
)

CASES = [case for kind in cases.kinds() if kind in NODES for case in cases.pairwise(cases.cases(kind))]
TORN = 0.05  # share of ordinary faces that may lie on a jump: where floors of floors are taken


@pytest.fixture(scope="module")
def findings():
    """Case → how it came out, from a few renders."""
    return dict(zip(CASES, measure.measured(CASES), strict=True))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_node_gives_what_cycles_gives(case, findings):
    found = findings[case]
    if found.state != EXACT:
        pytest.skip(f"{found.state}: {found.effect}")
    if case.kind == "TexSky":
        pytest.skip("float32 leaves 3e-4 near the ground: test_directions_against_cycles has its bounds")
    if found.reads:
        pytest.skip(f"looks at the scene: {', '.join(sorted(found.reads))}")
    assert found.ours.dtype == np.float32
    assert found.is_exact, str(found)
    assert found.torn[measure.ORDINARY].mean() <= TORN


def test_questions_are_not_trivial(findings):
    """Where a node has inputs, its answers vary; what rays meet among the sheets is not asked."""
    asked = {c: found for c, found in findings.items() if found.table and "raycast" not in found.reads}
    flat = [c.name for c, found in asked.items() if np.ptp(found.theirs) == 0]
    assert set(flat) <= CONSTANT


CONSTANT = {"Squeeze Value", "TexIES INTERNAL Fac", "Math COSH use_clamp Value"}
