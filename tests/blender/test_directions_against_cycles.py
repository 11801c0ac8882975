"""Sky Texture gives what Cycles gives, over random directions and settings.

Each sky is a table of 512 × 256 directions, made in float32 with Earth's radius in it. Ours repeats that
arithmetic, so the tables differ by rounding of sin, exp and pow alone. It is 1e-4 nearly everywhere, and
3e-4 looking down at ground a hundred metres away, where an altitude is rounded to half a metre.
"""

from typing import NamedTuple

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import cycles_nodes  # noqa: E402
from support.bpy_scenes import empty_scene  # noqa: E402
from support.node_lanes import NodeLanes  # noqa: E402

from pt_engine.blender.export.images import ImageTable  # noqa: E402
from pt_engine.blender.export.materials import export_material  # noqa: E402
from pt_engine.nodes.compile import compile_materials  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the models are those of Blender 5")

MULTIPLE, SINGLE = {"sky_type": "MULTIPLE_SCATTERING"}, {"sky_type": "SINGLE_SCATTERING"}
EVENING = {"sun_elevation": 0.02, "sun_rotation": 2.0, "sun_size": 0.6, "altitude": 3000.0, "sun_intensity": 0.7}
HAZE = {"sun_elevation": 1.9, "air_density": 2.0, "aerosol_density": 5.0, "ozone_density": 0.0, "sun_disc": False}
NIGHT = {"sun_elevation": -0.15, "sun_rotation": -1.0, "altitude": 0.0, "sun_size": 1.2}
CASES = {
    "multiple": MULTIPLE | {"sun_elevation": 0.3},
    "multiple, evening": MULTIPLE | EVENING,
    "multiple, haze": MULTIPLE | HAZE,
    "multiple, below the horizon": MULTIPLE | NIGHT,
    "single": SINGLE | {"sun_elevation": 0.3},
    "single, evening": SINGLE | EVENING,
    "single, haze": SINGLE | HAZE,
    "single, below the horizon": SINGLE | NIGHT,
    "Preetham": {"sky_type": "PREETHAM", "sun_direction": (0.3, -0.5, 0.4), "turbidity": 2.2},
    "Preetham, turbid": {"sky_type": "PREETHAM", "sun_direction": (-0.7, 0.1, 0.05), "turbidity": 8.0},
}


def directions(seed, settings):
    """(3, n) unit, half of them near the horizon, some near the sun."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(3, cycles_nodes.SIDE**2))
    d[2, ::2] *= 0.1
    if "sun_elevation" in settings:
        e, r = settings["sun_elevation"], settings.get("sun_rotation", 0.0)
        sun = np.array([np.cos(e) * np.sin(r), np.cos(e) * np.cos(r), np.sin(e)])
        d[:, ::5] = 0.3 * d[:, ::5] * settings.get("sun_size", 0.01) + sun[:, None]
    return (d / np.sqrt((d * d).sum(axis=0))).astype(np.float32)


@pytest.fixture(scope="module")
def answers():
    """Cycles' and our radiance in every case: name → (3, n) pair."""
    empty_scene()
    tables, materials = [], []
    for number, (name, settings) in enumerate(CASES.items()):
        table = {"A": directions(number, settings)}
        sheet = cycles_nodes.sheet(name, table, *cycles_nodes.place(number, len(CASES)))
        settings = settings | {"sun_disc": False}  # with a sun Blender's node has no Vector
        material = cycles_nodes.material(name, "TexSky", settings, {"Vector": "A"}, "Color")
        sheet.data.materials.append(material)
        tables.append(table)
        materials.append(material)
    picture = cycles_nodes.render(len(CASES))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([])
    compiled = compile_materials([export_material(m.evaluated_get(depsgraph), images) for m in materials])
    found = {}
    for number, name in enumerate(CASES):
        batch = compiled.batches[compiled.batch_of[number]]
        ours = batch.emission(NodeLanes(colors=tables[number], material=number))
        found[name] = cycles_nodes.cut(picture, number, len(CASES)), ours
    return found


@pytest.mark.parametrize("name", CASES)
def test_sky(name, answers):
    theirs, ours = answers[name]
    error = np.abs(ours - theirs) / (np.abs(theirs) + 0.01)
    worst = int(error.max(axis=0).argmax())
    assert (error <= 1e-4).mean() >= 0.97
    assert (error <= 3e-4).all(), f"{ours[:, worst]} instead of {theirs[:, worst]}"
    assert np.ptp(theirs) > 0
