"""Thin films against Cycles: on ideal mirrors, where an albedo is one number without noise.

"Exact" is |ours − Cycles| ≤ 1e-4·(|Cycles| + 0.01), over 16 thicknesses, indices and colours at 16 angles.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.furnaces import by_cycles_and_us, material, sheet  # noqa: E402

from pt_engine.nodes.coverage import EXACT  # noqa: E402

pytestmark = pytest.mark.skipif(
    bpy.app.version < (5, 0, 0), reason="4.5 has films on dielectrics alone, and less of them"
)

ROWS = 16
FILM = {"Thin Film Thickness": "A.x", "Thin Film IOR": "A.y"}
BLACK = (0.0, 0.0, 0.0, 1.0)
CASES = {
    "metal by colours": ("BsdfMetallic", {"Base Color": "B", "Edge Tint": "C"}, {}),
    "metal by index": (
        "BsdfMetallic", {"IOR": "D", "Extinction": "C"}, {"fresnel_type": "PHYSICAL_CONDUCTOR"}
    ),
    "principled metal": ("BsdfPrincipled", {"Metallic": 1.0, "Base Color": "B", "Specular Tint": "C"}, {}),
    "principled gloss": ("BsdfPrincipled", {"IOR": "D.x", "Base Color": BLACK, "Specular Tint": "C"}, {}),
    "principled gloss of a level": (
        "BsdfPrincipled", {"IOR": "D.x", "Specular IOR Level": "B.x", "Base Color": BLACK}, {}
    ),
    "reflection of principled glass": (
        "BsdfPrincipled",
        {"IOR": "D.x", "Transmission Weight": 1.0, "Specular Tint": "C", "Base Color": BLACK},
        {},
    ),
}  # fmt: skip


def rows_of_everything():
    """A: thickness (none, some under 1 nm, one beyond the table) and index; B, C: colours; D: indices."""
    rng = np.random.default_rng(7)
    thickness = rng.uniform(20, 1500, ROWS)
    thickness[:5] = 0, 0.05, 0.5, 5, 20_000
    ior = rng.uniform(1.0, 2.5, ROWS)
    ior[5:8] = 0.5, 1.0, 1.5
    d = rng.uniform(0.3, 3, (ROWS, 3))
    d[8] = 1.0
    colors = rng.random((2, ROWS, 3))
    colors[:, 9] = 1.0
    return {"A": np.stack([thickness, ior, 0 * ior], axis=1), "B": colors[0], "C": colors[1], "D": d}


@pytest.mark.parametrize(
    ("name", "behind"), [*((name, False) for name in CASES), ("reflection of principled glass", True)]
)
def test_mirrors_have_the_colours_they_have_in_cycles(name, behind, tmp_path):
    kind, links, settings = CASES[name]
    shape = sheet(np.linspace(0.1, 1.0, ROWS), behind, **rows_of_everything())
    made = lambda: material(kind, {"Roughness": 0.0, **links, **FILM}, **settings)  # noqa: E731
    theirs, ours, coverage = by_cycles_and_us(shape, made, 1, tmp_path, points=2)
    assert np.ptp(theirs) > 0.5
    np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-6)
    assert {entry.state for entry in coverage} == {EXACT}
