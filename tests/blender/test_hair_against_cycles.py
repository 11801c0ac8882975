"""Hair against Cycles, on triangles: values toward a sun, which are one number, and what is scattered in all.

Hair BSDF: 5e-4, as Cycles' arccosine and arctangent are approximations good to 1e-4. Principled Hair: 6e-3
where its variance is near 0.1, as Cycles' Bessel function is off by 1/(16x) beyond x = 12 (see
`bsdfs.hair_chiang`), and 1e-4 for half of all values. In all, Principled Hair scatters what it does in
Cycles, to 0.6 % of noise; the Hair BSDF does not, where Cycles samples directions that its own values leave
out.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.furnaces import by_cycles_and_us, material, sheet, values_by_cycles_and_us  # noqa: E402

from pt_engine.nodes.coverage import EXACT  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="4.5 names the node's inputs otherwise")

SUNS = [(0.3, 0.5, 0.8), (-0.6, 0.2, 0.4), (0.2, -0.7, -0.6), (-0.5, 0.3, -0.8)]
ROUGH = {"Roughness": "A.x", "Radial Roughness": "A.y", "Offset": "A.z", "IOR": "D.x"}
RANDOM = {"Random": "D.y", "Random Roughness": "D.z", "Random Color": "D.z"}
WAYS = {
    "COLOR": {"Color": "B"},
    "ABSORPTION": {"Absorption Coefficient": "C"},
    "MELANIN": {"Melanin": "C.x", "Melanin Redness": "C.y", "Tint": "B"},
}
LOBE = {"RoughnessU": "A.x", "RoughnessV": "A.y", "Offset": "A.z"}


@pytest.fixture(scope="module")
def shape():
    """Eight hairs at eight angles: A roughness, offset; B, C colours; D index, random numbers; T tangent."""
    rng, n = np.random.default_rng(2), 8
    a = np.stack([rng.uniform(0.02, 1, n), rng.uniform(0.05, 1, n), rng.uniform(-0.3, 0.3, n)], axis=1)
    d = np.stack([rng.uniform(1.2, 2, n), rng.random(n), rng.random(n)], axis=1)
    b, c = rng.uniform(0.02, 1, (2, n, 3))
    return sheet(np.linspace(0.15, 1, 8), aside=True, A=a, B=b, C=c, D=d, T=rng.normal(size=(n, 3)))


@pytest.mark.parametrize("tangent", [{}, {"Tangent": "T"}], ids=["edge", "tangent"])
@pytest.mark.parametrize("component", ["Reflection", "Transmission"])
def test_one_lobe_has_cycles_values(component, tangent, shape, tmp_path):
    lit = 0
    for sun in SUNS:
        theirs, ours, coverage = values_by_cycles_and_us(
            shape, lambda: material("BsdfHair", LOBE | tangent, component=component), sun, tmp_path
        )
        np.testing.assert_allclose(ours, theirs, rtol=5e-4, atol=1e-5)
        lit += np.count_nonzero(theirs)
        assert {entry.state for entry in coverage} == {EXACT}
    assert lit > 3 * 60


@pytest.mark.parametrize("way", WAYS)
def test_principled_hair_has_cycles_values(way, shape, tmp_path):
    for sun in SUNS:
        theirs, ours, coverage = values_by_cycles_and_us(
            shape,
            lambda: material(
                "BsdfHairPrincipled", WAYS[way] | ROUGH | RANDOM | {"Coat": "D.y"}, parametrization=way
            ),
            sun,
            tmp_path,
        )
        error = np.abs(ours - theirs) / (theirs + 0.01)
        assert error.max() <= 6e-3
        assert np.median(error) <= 1e-4
        assert np.count_nonzero(theirs) > 3 * 50
        assert {entry.state for entry in coverage} == {EXACT}


@pytest.mark.parametrize("way", WAYS)
def test_principled_hair_scatters_as_much_as_in_cycles(way, shape, tmp_path):
    theirs, ours, _ = by_cycles_and_us(
        shape,
        lambda: material("BsdfHairPrincipled", WAYS[way] | ROUGH | RANDOM, parametrization=way),
        1024,
        tmp_path,
        points=2048,
    )
    np.testing.assert_allclose(ours, theirs, rtol=6e-3, atol=1e-3)
