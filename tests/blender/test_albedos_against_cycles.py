"""Closure by closure, what is scattered in all is what Cycles scatters: patches under a white sky.

Closures, their settings and inputs are enumerated from this Blender (`support.parity`), here at two angles;
`python -m bench.parity` takes five, and more samples. Both engines' tables for light that bounces between
facets are good to 0.4 %; the rest is four standard errors of Cycles' noise.
"""

import pytest

bpy = pytest.importorskip("bpy")
from support.parity import closures, spheres  # noqa: E402

from pt_engine.nodes.coverage import EXACT  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the closures follow Cycles 5")

COSINES = (0.9, 0.25)
SAMPLES = 128  # of each of 16 pixels, twice
TABLES = 4e-3
PATCHES = closures.patches()


@pytest.fixture(scope="module")
def albedos(tmp_path_factory):
    """Patch → its albedos."""
    found = closures.reflected(PATCHES, COSINES, SAMPLES, tmp_path_factory.mktemp("patches"), 1 << 14)
    return {patch: [one for one in found if one.patch == patch] for patch in PATCHES}


@pytest.mark.parametrize("patch", PATCHES, ids=lambda patch: patch.name)
def test_closure_scatters_as_much_as_in_cycles(patch, albedos):
    for one in albedos[patch]:
        if one.state != EXACT:
            pytest.skip(f"{one.state}: {one.effect}")
        assert one.error < TABLES + 4 * one.sigma, f"{one.ours} instead of {one.theirs} at {one.cos}"


@pytest.mark.slow
def test_spheres_in_a_studio_look_as_in_cycles(tmp_path):
    """No sphere differs significantly (Welch's test with both variances), or all of it by less than 1 %."""
    found = spheres.compared(24, tmp_path)
    wrong = {name: str(agreement) for name, agreement in found if not agreement.agrees(tolerance=0.01)}
    assert wrong == {}
