"""Textures of directions give what Cycles gives: skies, environment maps, luminaires.

Each sky is a table of 512 × 256 directions, made in float32 with Earth's radius in it. Ours repeats that
arithmetic, so the tables differ by rounding of sin, exp and pow alone. It is 1e-4 nearly everywhere, and
3e-4 looking down at ground a hundred metres away, where an altitude is rounded to half a metre.
"""

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
NO_SUN = {"sun_disc": False}  # with a sun Blender's node has no Vector: see test_sun_against_cycles
EVENING = NO_SUN | {"sun_elevation": 0.02, "sun_rotation": 2.0, "altitude": 3000.0}
HAZE = NO_SUN | {"sun_elevation": 1.9, "air_density": 2.0, "aerosol_density": 5.0, "ozone_density": 0.0}
NIGHT = NO_SUN | {"sun_elevation": -0.15, "sun_rotation": -1.0, "altitude": 0.0}
HOSEK = ((2.2, 0.3, 0.8), (1.0, 1.0, 0.3), (10.0, 0.0, 0.02), (6.7, 0.8, 3.0))

HEAD = "IESNA:LM-63-1995\n[TEST] none\nTILT={}\n1 1000 {} {} {} {} 1 0.1 0.2 0.3\n0.9 1.1 50\n"


def ies(kind, vertical, horizontal, tilt="NONE", multiplier=20):
    """The text of a file with a lively table."""
    rng = np.random.default_rng(len(vertical))
    values = rng.uniform(1, 9, (len(horizontal), len(vertical)))
    head = HEAD.format(tilt, multiplier, len(vertical), len(horizontal), kind)
    rows = [vertical, horizontal, *values]
    return head + "\n".join(" ".join(f"{x:.5g}" for x in row) for row in rows)


def angles(first, last, count):
    return np.linspace(first, last, count)


LUMINAIRES = {
    "round": ies(1, angles(0, 180, 10), [0]),
    "downward, a quadrant": ies(1, angles(0, 90, 7), angles(0, 90, 4)),
    "half": ies(1, angles(0, 180, 7), angles(0, 180, 5), "INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8"),
    "all around": ies(1, [0, 10, 30, 45, 100, 170], [0, 20, 90, 200, 300, 360]).replace(" ", ","),
    "without its end": ies(1, angles(0, 180, 7), angles(0, 330, 12)),
    "from 90 to 270": ies(1, angles(0, 180, 7), angles(90, 270, 5)),
    "type B": ies(2, angles(0, 90, 5), angles(0, 90, 4)),
    "type B, both sides": ies(2, angles(-90, 90, 5), angles(-90, 90, 7)),
    "type A": ies(3, angles(-90, 90, 5), angles(0, 90, 4)),
    "type A, both sides": ies(3, angles(-90, 90, 5), angles(-90, 90, 7)),
    "no file of this kind": "nothing",
}


def text(content):
    """Sets an internal text."""

    def make(node):
        node.mode, node.ies = "INTERNAL", bpy.data.texts.new("ies")
        node.ies.write(content)

    return make


def picture(colorspace, floats):
    """Sets an image of 16 × 8 random pixels."""

    def make(node):
        image = bpy.data.images.new("sky", 16, 8, float_buffer=floats)
        image.colorspace_settings.name = colorspace
        values = np.random.default_rng(3).uniform(0, 1, (16 * 8, 4)).astype(np.float32)
        values[:, 3] = 1
        image.pixels.foreach_set(values.ravel())
        image.pack()
        node.image = image

    return make


def lost(node):
    """Sets an image whose file is missing."""
    node.image = bpy.data.images.new("lost", 4, 4)
    node.image.source, node.image.filepath = "FILE", "/nowhere/lost.exr"


MAPS = {
    f"map {projection} {interpolation}": {
        "projection": projection,
        "interpolation": interpolation,
        "image": picture("sRGB", False),
    }
    for projection in ("EQUIRECTANGULAR", "MIRROR_BALL")
    for interpolation in ("Linear", "Closest", "Cubic")
}
CASES = {
    "multiple": ("TexSky", "Color", MULTIPLE | NO_SUN),
    "multiple, evening": ("TexSky", "Color", MULTIPLE | EVENING),
    "multiple, haze": ("TexSky", "Color", MULTIPLE | HAZE),
    "multiple, night": ("TexSky", "Color", MULTIPLE | NIGHT),
    "single": ("TexSky", "Color", SINGLE | NO_SUN),
    "single, evening": ("TexSky", "Color", SINGLE | EVENING),
    "single, haze": ("TexSky", "Color", SINGLE | HAZE),
    "single, night": ("TexSky", "Color", SINGLE | NIGHT),
    "Preetham": (
        "TexSky", "Color", {"sky_type": "PREETHAM", "sun_direction": (0.3, -0.5, 0.4), "turbidity": 2.2},
    ),
    "Preetham, turbid": (
        "TexSky", "Color", {"sky_type": "PREETHAM", "sun_direction": (-0.7, 0.1, 0.05), "turbidity": 8.0},
    ),
    **{
        f"Hosek, {turbidity}, {albedo}, {height}": (
            "TexSky",
            "Color",
            {
                "sky_type": "HOSEK_WILKIE",
                "sun_direction": (0.3, -0.5, height),
                "turbidity": turbidity,
                "ground_albedo": albedo,
            },
        )
        for turbidity, albedo, height in HOSEK
    },
    **{f"luminaire, {name}": ("TexIES", "Fac", {"ies": text(body)}) for name, body in LUMINAIRES.items()},
    **{name: ("TexEnvironment", "Color", settings) for name, settings in MAPS.items()},
    "map of floats": ("TexEnvironment", "Color", {"image": picture("Linear Rec.709", True)}),
    "map of data": ("TexEnvironment", "Color", {"image": picture("Non-Color", False)}),
    "map that is lost": ("TexEnvironment", "Color", {"image": lost}),
}  # fmt: skip
FLAT = {"luminaire, no file of this kind", "map that is lost"}
# share of directions within rounding of a texel's border, or of where a ball's image is a point
JUMPS = {name: 0.05 if "Closest" in name else 0.005 for name in MAPS}


def directions(seed):
    """(3, n) unit, half of them near the horizon."""
    d = np.random.default_rng(seed).normal(size=(3, cycles_nodes.SIDE**2))
    d[2, ::2] *= 0.1
    return (d / np.sqrt((d * d).sum(axis=0))).astype(np.float32)


@pytest.fixture(scope="module")
def answers():
    """Cycles' and our values in every case: name → (3, n) pair."""
    empty_scene()
    tables, materials = [], []
    for number, (name, (kind, output, settings)) in enumerate(CASES.items()):
        table = {"A": directions(number)}
        if name in MAPS:
            table["A"][:, 0] = 0  # nowhere
        sheet = cycles_nodes.sheet(name, table, *cycles_nodes.place(number, len(CASES)))
        material = cycles_nodes.material(name, kind, settings, {"Vector": "A"}, output)
        sheet.data.materials.append(material)
        tables.append(table)
        materials.append(material)
    picture = cycles_nodes.render(len(CASES))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([])
    graphs = [export_material(m.evaluated_get(depsgraph), images) for m in materials]
    compiled = compile_materials(graphs, images.images)
    found = {}
    for number, name in enumerate(CASES):
        batch = compiled.batches[compiled.batch_of[number]]
        ours = batch.emission(NodeLanes(colors=tables[number], material=number))
        theirs = cycles_nodes.cut(picture, number, len(CASES))
        found[name] = theirs, np.broadcast_to(ours, theirs.shape)
    return found


@pytest.mark.parametrize("name", CASES)
def test_texture_of_directions(name, answers):
    theirs, ours = answers[name]
    error = (np.abs(ours - theirs) / (np.abs(theirs) + 0.01)).max(axis=0)
    worst = int(error.argmax())
    message = f"{ours[:, worst]} instead of {theirs[:, worst]}, {(error > 1e-4).sum()} differ"
    assert (error <= (3e-4 if CASES[name][0] == "TexSky" else 1e-4)).mean() >= 1 - JUMPS.get(name, 0), message
    assert (error <= 1e-4).mean() >= 0.94, message
    assert (np.ptp(theirs, axis=1).max() > 1e-3) != (name in FLAT)
    if name in MAPS:
        assert error[0] <= 1e-4
