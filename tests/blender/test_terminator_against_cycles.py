"""Coarse smooth meshes where light grazes: Cycles' picture, with its default geometry offset and without.

Lamps of a single direction make no noise, so that steps of the shadow show as they are.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import ztest  # noqa: E402
from support.bpy_scenes import add, export  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.items import bent_normals  # noqa: E402
from support.terminators import FRONT, LAMPS, build  # noqa: E402
from support.tufts import background  # noqa: E402

pytestmark = pytest.mark.slow  # physics that no Python changes

SIZE, CELLS, SAMPLES = (64, 48), (8, 6), 32


def pictures(folder, size=SIZE, samples=SAMPLES):
    """Colours of Cycles' pair and of ours."""
    pairs = by_cycles(samples, size, folder), by_engine(samples, size)
    return [[image[..., :3] for image in pair] for pair in pairs]


def assert_same(folder):
    """To one per cent: silhouettes jitter differently where there is no noise else to tell them apart."""
    cycles, ours = pictures(folder)
    agreement = ztest.compare(ours, cycles, CELLS)
    assert np.mean(cycles) > 1e-3
    assert agreement.agrees(0.01), str(agreement)


@pytest.mark.parametrize("offset", [0.0, 0.1])
@pytest.mark.parametrize("lamp", LAMPS)
@pytest.mark.parametrize("kind", ["ball", "cone"])
def test_shadow_is_that_of_cycles(kind, lamp, offset, tmp_path):
    build(kind, lamp, offset)
    assert_same(tmp_path)


MORE = {
    "through": {"shader": "BsdfTranslucent"},
    "through, point": {"shader": "BsdfTranslucent", "lamp": "POINT"},
    "gloss": {"shader": "BsdfPrincipled", "offset": 0.3},
    "from within": {"kind": "half", "place": FRONT},
    "from within, point": {"kind": "half", "place": FRONT, "lamp": "POINT"},
    "cone, wide": {"kind": "cone", "offset": 1.0, "lamp": "AREA"},
}


@pytest.mark.parametrize("name", MORE)
def test_other_shadows_are_too(name, tmp_path):
    build(**MORE[name])
    assert_same(tmp_path)


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.5])
def test_bent_normals_under_a_fan_of_suns(offset, tmp_path):
    """From each direction, between the horizons of triangles and normals too, and below both."""
    bent_normals()
    square, sun = bpy.data.objects["Square"], bpy.data.objects["Sun"]
    square.shadow_terminator_geometry_offset, sun.data.angle = offset, 0.0
    background(bpy.context.scene).inputs["Strength"].default_value = 0.0
    lit = []
    for turn in np.radians([-120, -90, -40, 30, 80, 105, 135]):  # about the square's own axis
        sun.rotation_euler = (np.pi / 2, 0, turn)
        cycles, ours = (np.mean(pair) for pair in pictures(tmp_path, (24, 16)))
        lit.append(cycles)
        assert abs(ours - cycles) < 0.005 * cycles + 1e-4, (turn, ours, cycles)
    assert min(lit) < 0.1 * max(lit)


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.5])
def test_bent_normals_under_a_uniform_sky(offset, tmp_path):
    """To three in a thousand: neither samples such a sky, so no direction between the horizons counts."""
    bent_normals()
    bpy.data.objects["Square"].shadow_terminator_geometry_offset = offset
    cycles, ours = pictures(tmp_path, (24, 16), 128)
    agreement = ztest.compare(ours, cycles, (6, 4))
    assert agreement.agrees(0.003), str(agreement)


@pytest.mark.parametrize("height", [1.3, -1.3])
@pytest.mark.parametrize("users", [1, 2])
def test_stretched_and_mirrored(users, height, tmp_path):
    """Cycles blends other normals where it moves a mesh into the world: 4 to 6 % of the image (`alone`)."""
    owner = build(scale=(1, 0.6, height))
    if users == 2:
        add(owner.data, "Other", location=(0, 50, 0))
    assert_same(tmp_path)


def test_the_comparison_sees_the_steps(tmp_path):
    """Without the offset the ball's shadow follows its faces: ten times the tolerance above."""
    build(offset=0.1)
    cycles, _ = pictures(tmp_path)
    bpy.data.objects["Shape"].shadow_terminator_geometry_offset = 0.0
    ours = [image[..., :3] for image in by_engine(SAMPLES, SIZE)]
    agreement = ztest.compare(ours, cycles, CELLS)
    assert agreement.error > 0.1, str(agreement)


SHADES = {
    "diffuse": {"lamp": "POINT"},
    "through": {"shader": "BsdfTranslucent"},
    "gloss": {"shader": "BsdfPrincipled", "lamp": "AREA"},
    "mirror": {"shader": "BsdfGlossy", "lamp": "AREA"},
}


@pytest.mark.parametrize("name", SHADES)
def test_light_fades_as_in_cycles(name, tmp_path):
    """The shading offset, of whatever closure."""
    build(**SHADES[name]).shadow_terminator_shading_offset = 0.6
    if name == "mirror":
        bpy.data.materials["BsdfGlossy"].node_tree.nodes["Glossy BSDF"].inputs["Roughness"].default_value = 0
    assert_same(tmp_path)


def test_each_object_has_its_own():
    owner = build(offset=0.25)
    owner.shadow_terminator_shading_offset = 0.5
    add(owner.data, "Other").shadow_terminator_geometry_offset = 0.0
    instances = export().instances
    rows = zip(instances.names, instances.terminator.tolist(), instances.shading_offset.tolist(), strict=True)
    assert set(rows) == {("Shape", 0.25, 0.5), ("Other", 0.0, 0.0)}
