"""Hair against Cycles, on triangles: values toward a sun, which are one number, and what is scattered in all.

Hair BSDF: 5e-4, as Cycles' arccosine and arctangent are approximations good to 1e-4. Principled Hair: 3e-4,
float32's rounding of M's large exponents, with Cycles' Bessel function in the place of ours, which is off by
1/(16x) beyond x = 12, so by up to 0.5 %. In all, Principled Hair scatters what it does in Cycles, to 0.6 % of
noise; the Hair BSDF does not, where Cycles samples directions that its own values leave out. And on triangles
Cycles takes Principled Hair's Y = T × wi for a bumped normal of n: light from lamps, though not what its own
samples find, is missing where (n·wo)(n·Y)(Y·wo) < 0. Ours is there.
"""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.furnaces import by_cycles_and_us, material, sheet, values_by_cycles_and_us  # noqa: E402

from pt_engine.bsdfs import hair_chiang  # noqa: E402
from pt_engine.nodes.coverage import EXACT  # noqa: E402

SUNS = [(0.3, 0.5, 0.8), (-0.6, 0.2, 0.4), (0.2, -0.7, -0.6), (-0.5, 0.3, -0.8)]
ROUGH = {"Roughness": "A.x", "Radial Roughness": "A.y", "Offset": "A.z", "IOR": "D.x"}
RANDOM = {"Random": "D.y", "Random Roughness": "D.z", "Random Color": "D.z"}
WAYS = {
    "COLOR": {"Color": "B"},
    "ABSORPTION": {"Absorption Coefficient": "C"},
    "MELANIN": {"Melanin": "C.x", "Melanin Redness": "C.y", "Tint": "B"},
}
LOBE = {"RoughnessU": "A.x", "RoughnessV": "A.y", "Offset": "A.z"}


@pytest.fixture(scope="module", params=["x", "y"], ids=["edge x", "edge y"])
def shape(request):
    """Eight hairs at eight angles: A roughness, offset; B, C colours; D index, random numbers; T tangent."""
    rng, n = np.random.default_rng(2), 8
    a = np.stack([rng.uniform(0.02, 1, n), rng.uniform(0.05, 1, n), rng.uniform(-0.3, 0.3, n)], axis=1)
    d = np.stack([rng.uniform(1.2, 2, n), rng.random(n), rng.random(n)], axis=1)
    b, c = rng.uniform(0.02, 1, (2, n, 3))
    return sheet(np.linspace(0.15, 1, 8), edge=request.param, A=a, B=b, C=c, D=d, T=rng.normal(size=(n, 3)))


def cycles_bessel_scaled(x):
    """exp(−x) I0(x) by ten terms of the series, and above 12 by half of the expansion's second term."""
    y = (np.minimum(x, 12) / 2) ** 2
    series = sum(y**k / float(math.factorial(k)) ** 2 for k in range(10)) * np.exp(-np.minimum(x, 12))
    large = np.maximum(x, 12)
    beyond = np.exp(0.5 * (1 / (8 * large) - np.log(2 * np.pi) - np.log(large)))
    return np.where(x > 12, beyond, series).astype(np.float32)


def taken_for_bumped(shape, sun):
    """Where Cycles takes T × wi for a normal that the light is behind."""
    n = shape.normals.astype(np.float64)
    beside = np.cross(
        [0, 1, 0] if shape.edge == "y" else np.stack([n[2], 0 * n[2], -n[0]], axis=1), [0, 0, 1]
    )
    beside = np.broadcast_to(beside, (n.shape[1], 3)).T
    light = np.array(sun)
    return (light @ n) * (n * beside).sum(axis=0) * (light @ beside) < 0


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
        assert ["under a sky" in entry.effect for entry in coverage if entry.state != EXACT] == [True]
    assert lit > 3 * 60


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="4.5's Cycles takes other normals for bumped")
@pytest.mark.parametrize("way", WAYS)
def test_principled_hair_has_cycles_values(way, shape, tmp_path, monkeypatch):
    monkeypatch.setattr(hair_chiang, "_bessel_scaled", cycles_bessel_scaled)
    for sun in SUNS:
        theirs, ours, coverage = values_by_cycles_and_us(
            shape,
            lambda: material(
                "BsdfHairPrincipled", WAYS[way] | ROUGH | RANDOM | {"Coat": "D.y"}, parametrization=way
            ),
            sun,
            tmp_path,
        )
        missing = taken_for_bumped(shape, sun)
        assert not theirs[:, missing].any()
        error = (np.abs(ours - theirs) / (theirs + 0.01))[:, ~missing]
        assert error.max() <= 3e-4
        assert np.count_nonzero(theirs) > 3 * 20
        assert ["were bumped" in entry.effect for entry in coverage if entry.state != EXACT] == [True]


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


@pytest.fixture(scope="module")
def huang_shape():
    """Hairs at four angles: A roughness and tilt, C absorption from none to black."""
    a = [[0.05, 0, 0], [0.3, 0, 0.1], [0.3, 0, 0], [0.6, 0, -0.1], [1, 0, 0]]
    c = [[0, 0.2, 1.5], [0.2, 0.6, 50], [0, 0.2, 1.5], [0, 0.3, 1], [0, 0.2, 1.5]]
    return sheet([0.3, 0.55, 0.8, 1], edge="x", A=a, C=c)


@pytest.mark.parametrize("aspect", [1.0, pytest.param(0.4, marks=pytest.mark.slow)])
def test_huangs_hair_scatters_as_much_as_in_cycles(aspect, huang_shape, tmp_path):
    """Under a sky, where Cycles' sampler counts; noise of Cycles: 4 % of one hair's blue, 0.8 % of all."""
    theirs, ours, coverage = by_cycles_and_us(
        huang_shape, lambda: huangs_hair(aspect), 512, tmp_path, points=4096
    )
    np.testing.assert_allclose(ours.mean(axis=1), theirs.mean(axis=1), rtol=0.025)
    np.testing.assert_allclose(ours, theirs, rtol=0.2, atol=1e-3)
    assert ["toward lamps" in entry.effect for entry in coverage if entry.state != EXACT] == [True]


def huangs_hair(aspect):
    links = {"Roughness": "A.x", "Offset": "A.z", "Absorption Coefficient": "C"}
    made = material("BsdfHairPrincipled", links, model="HUANG", parametrization="ABSORPTION")
    hair = next(node for node in made.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfHairPrincipled")
    hair.inputs["Aspect Ratio"].default_value = aspect
    return made
