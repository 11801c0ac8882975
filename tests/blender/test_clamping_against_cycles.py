"""Clamped light is Cycles': white walls in a corner under a lamp without a size, after one bounce and two.

Direct light has no choice but the place in the pixel. Light after two bounces is drawn in proportion to the
cosine by both, and roulette is off, so contributions have the same distribution and lose the same.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.ztest import compare  # noqa: E402

SIZE, SAMPLES, SIDE = (24, 16), 256, 3.0
WALLS = [((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)), ((0, 0, 1), (1, 0, 0))]


@pytest.fixture(scope="module")
def corner():
    """Three walls; the lamp is so near that a few contributions carry much of the light."""
    scene = empty_scene()
    white = bpy.data.materials.new("White")
    tree = with_nodes(white)
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.9, 0.7, 0.4, 1.0)
    tree.links.new(diffuse.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    for wall in WALLS:
        one, other = (SIDE * np.array(edge) for edge in wall)
        sheet = mesh([0 * one, one, one + other, other], [(0, 1, 2, 3)])
        sheet.materials.append(white)
        add(sheet)
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 40.0, 0.0
    add(lamp, location=(0.25, 1.0, 0.3))
    scene.camera.location, scene.camera.rotation_euler = (6, 6, 6), (0.9553, 0, 2.3562)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    return scene


def both(tmp_path, direct, indirect, bounces):
    """Two images each by Cycles and by us, colours alone."""
    more = {"sample_clamp_direct": direct, "sample_clamp_indirect": indirect, "max_bounces": bounces}
    theirs = by_cycles(SAMPLES, SIZE, tmp_path, **more, diffuse_bounces=bounces, min_light_bounces=8)
    own = {"clamp_direct": direct, "clamp_indirect": indirect, "max_depth": bounces + 2, "rr_depth": 64}
    ours = by_engine(SAMPLES, SIZE, **own)
    return [image[..., :3] for image in theirs], [image[..., :3] for image in ours]


@pytest.mark.parametrize(
    ("direct", "indirect", "bounces", "left"), [(0.5, 0.0, 0, 0.95), (0.0, 0.1, 1, 0.99), (0.3, 0.05, 1, 0.9)]
)
def test_what_is_left_is_cycles(corner, tmp_path, direct, indirect, bounces, left):
    """In the mean, cell by cell and pixel by pixel; and it is less than without a clamp."""
    theirs, ours = both(tmp_path, direct, indirect, bounces)
    found = compare(ours, theirs)
    assert found.p > 1e-3
    assert found.pixel_error < 0.02
    free = by_engine(SAMPLES, SIZE, max_depth=bounces + 2, rr_depth=64)[0][..., :3]
    assert ours[0].mean() < left * free.mean()
