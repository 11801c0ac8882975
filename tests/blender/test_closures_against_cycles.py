"""Closure by closure, f·cosθo is Cycles' for the same pairs of directions, and is zero where Cycles' is.

"Exact" is |ours − Cycles| ≤ 1e-4·(|Cycles| + 0.01) at every pixel, as for nodes.
"""

from functools import partial

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import lit_faces  # noqa: E402

PHONG = "ASHIKHMIN_SHIRLEY"
STRETCHED = {"Rotation": 0.1, "Tangent": (0.5, 0.3, 0.1)}
COLOR = (0.9, 0.5, 0.2)


def case(kind, sockets, **settings):
    """A material to be made in the scene of the test."""
    name = " ".join([kind, *(str(v) for v in settings.values()), *(f"{k} {v}" for k, v in sockets.items())])
    made = partial(lit_faces.material, kind, {"Color": COLOR} | sockets, **settings)
    return pytest.param(made, id=name)


CASES = [
    *(case("BsdfSheen", {"Roughness": r}, distribution="MICROFIBER") for r in (0.0, 0.05, 0.31, 0.7, 1.0)),
    *(case("BsdfSheen", {"Roughness": r}, distribution="ASHIKHMIN") for r in (0.0, 0.1, 0.5, 1.0)),
    *(
        case("BsdfToon", {"Size": size, "Smooth": smooth}, component=component)
        for component in ("DIFFUSE", "GLOSSY")
        for size, smooth in ((0.5, 0.0), (0.3, 0.4), (0.7, 0.9), (0.0, 1.0), (1.0, 0.3))
    ),
    *(case("BsdfAnisotropic", {"Roughness": r}, distribution=PHONG) for r in (0.3, 0.6, 1.0)),
    *(
        case("BsdfAnisotropic", STRETCHED | {"Roughness": r, "Anisotropy": a}, distribution=distribution)
        for distribution in (PHONG, "GGX")
        for r, a in ((0.5, 0.5), (0.7, -0.7), (0.9, 0.99))
    ),
]


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """Cycles' and our pixels of every case, from one scene."""
    return lit_faces.pictures([row.values[0] for row in CASES], tmp_path_factory.mktemp("lit"))


@pytest.mark.parametrize("number", [pytest.param(k, id=row.id) for k, row in enumerate(CASES)])
def test_closure_reflects_what_cycles_reflects(number, answers):
    theirs, ours = answers[0][number], answers[1][number]
    error = np.abs(ours - theirs) / (np.abs(theirs) + 0.01)
    worst = np.unravel_index(error.argmax(), error.shape)
    assert error.max() <= 1e-4, (
        f"{(error > 1e-4).mean():.1%} differ, {ours[worst]} instead of {theirs[worst]}"
    )
