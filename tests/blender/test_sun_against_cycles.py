"""The sun of a Sky Texture, as Cycles has it: its disc pixel by pixel, and its light in a scene."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from mathutils import Euler  # noqa: E402
from support.bpy_scenes import empty_scene, export  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.skies import box_outdoors, sky  # noqa: E402
from support.ztest import compare  # noqa: E402

from pt_engine.scene.prepare import prepare  # noqa: E402
from pt_engine.scene.wave import Rays  # noqa: E402
from pt_engine.scene.world_light import seen  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the models are those of Blender 5")
SIZE = 32
FIRST = 0.5 + 0.5 / 1022  # where in a pixel Cycles' first sample lies
SUN = {"sun_elevation": 0.02, "sun_rotation": 1.1, "sun_size": 0.06, "sun_intensity": 0.01}


def look_at_sun(scene, elevation, rotation, wide=0.08):
    """The camera sees the sun and as much again around it."""
    camera = scene.camera
    camera.location = (0, 0, 0)
    camera.rotation_euler = Euler((np.pi / 2 + elevation, 0, -rotation))
    camera.data.angle = wide


@pytest.mark.parametrize("model", ["SINGLE_SCATTERING", "MULTIPLE_SCATTERING"])
@pytest.mark.parametrize("altitude", [300.0, 8000.0])
def test_disc(model, altitude, tmp_path):
    """Half sunk: the horizon, which the altitude lowers, cuts it. Pixels on a border may fall on either side.

    Not lower: at an altitude of a metre or two the ground's distance is a matter of float32.
    """
    scene = empty_scene()
    sky(scene, sky_type=model, altitude=altitude, **SUN)
    look_at_sun(scene, SUN["sun_elevation"], SUN["sun_rotation"])
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.cycles.use_adaptive_sampling = False
    theirs = by_cycles(1, (SIZE, SIZE), tmp_path)[0][..., :3]
    made = prepare(export(size=(SIZE, SIZE)))
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    rays = Rays(
        *made.camera.at_resolution(SIZE, SIZE).rays(
            (np.stack([x.ravel(), y.ravel()]) + FIRST).astype(np.float32)
        )
    )
    ours = seen(made.world, rays.d, made.view).T.reshape(SIZE, SIZE, 3)[::-1]
    error = (np.abs(ours - theirs) / (np.abs(theirs) + 0.01)).max(axis=-1)
    assert theirs.max() > 10 * np.median(theirs)
    assert (error > 1e-3).sum() <= SIZE // 4


@pytest.mark.parametrize("turned", [(0, 0, 0), (0.5, 0.2, 1.0)])
def test_scene(turned, tmp_path):
    """A box on the ground in the afternoon."""
    scene = empty_scene()
    sky(scene, sky_type="MULTIPLE_SCATTERING", sun_elevation=0.5, sun_rotation=2.0, turned=turned)
    box_outdoors(scene)
    size, samples = (32, 24), 128
    theirs, mine = by_cycles(samples, size, tmp_path), by_engine(samples, size)
    found = compare(*(tuple(image[..., :3] for image in pair) for pair in (mine, theirs)), grid=(8, 6))
    assert found.agrees(0.01), str(found)
    assert found.noise < 0.1
