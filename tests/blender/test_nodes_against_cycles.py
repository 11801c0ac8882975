"""Node by node, our programs give what Cycles gives (the Cycles inside bpy), over random and hostile inputs.

"Exact" is |ours − Cycles| ≤ 1e-4·(|Cycles| + 0.01) at every pixel. Where a node has jumps (a cell's
border, a floor), an input within rounding of the jump may land on the other side: such cases say what
share of pixels may differ.
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

pytestmark = pytest.mark.skipif(
    bpy.app.version < (5, 0, 0),
    reason="the nodes follow Cycles 5: 4.5 hashes Voronoi's cells and rounds its colour matrices otherwise",
)

MATH = {"Value": "A.x", "Value_001": "B.y", "Value_002": "C.z"}
VECTOR = {"Vector": "A", "Vector_001": "B", "Vector_002": "C", "Scale": "D.x"}
JUMPY = 0.02  # share of pixels that may fall on the other side of a jump


class Case(NamedTuple):
    """A node's settings, what feeds it, which output is looked at, and how many pixels may differ."""

    name: str
    kind: str
    output: str
    links: dict
    jumps: float
    bounds: tuple
    settings: dict


def case(kind, output, links, jumps=0.0, low=-2.0, high=2.0, **settings):
    """One row of the table."""
    named = [v for v in settings.values() if not callable(v)]
    name = " ".join([kind, *(str(v) for v in named), output])
    return pytest.param(Case(name, kind, output, links, jumps, (low, high), settings), id=name)


def enum(kind, prop):
    """Values of a node's enum in this Blender."""
    return [e.identifier for e in getattr(bpy.types, "ShaderNode" + kind).bl_rna.properties[prop].enum_items]


def math_cases():
    for operation in enum("Math", "operation"):
        yield case("Math", "Value", MATH, operation=operation)
    yield case("Math", "Value", MATH, operation="MULTIPLY_ADD", use_clamp=True)
    numbers = {"DOT_PRODUCT", "DISTANCE", "LENGTH"}
    for operation in enum("VectorMath", "operation"):
        output = "Value" if operation in numbers else "Vector"
        yield case("VectorMath", output, VECTOR, operation=operation)
    for kind in enum("MapRange", "interpolation_type"):
        for clamp in (False, True):
            names = ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
            links = dict(zip(names, ("A.x", "A.y", "B.x", "B.y", "C.x", "C.y"), strict=True))
            yield case("MapRange", "Result", links, JUMPY, interpolation_type=kind, clamp=clamp)
        names = ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3")
        links = dict(zip(names, ("A", "B", "C", "D", (1.0, 2.0, 3.0)), strict=True))
        yield case(
            "MapRange", "Vector", links, JUMPY, data_type="FLOAT_VECTOR", interpolation_type=kind, clamp=False
        )
    for kind in enum("Clamp", "clamp_type"):
        yield case("Clamp", "Result", {"Value": "A.x", "Min": "B.x", "Max": "C.x"}, clamp_type=kind)


def vector_cases():
    mapping = {"Vector": "A", "Location": "B", "Rotation": "C", "Scale": "D"}
    for kind in enum("Mapping", "vector_type"):
        yield case("Mapping", "Vector", mapping, vector_type=kind)
        yield case("Mapping", "Vector", {"Vector": "A", "Location": "B", "Scale": "D"}, vector_type=kind)
    rotate = {"Vector": "A", "Center": "B", "Axis": "C", "Angle": "D.x", "Rotation": "D"}
    for kind in enum("VectorRotate", "rotation_type"):
        for invert in (False, True):
            yield case("VectorRotate", "Vector", rotate, rotation_type=kind, invert=invert)
    yield case("SeparateXYZ", "Y", {"Vector": "A"})
    yield case("CombineXYZ", "Vector", {"X": "A.x", "Y": "B.y", "Z": "C.z"})

    def tilt(node):
        node.outputs[0].default_value = (0.5, -0.3, 0.8)

    yield case("Normal", "Normal", {"Normal": "A"}, direction=tilt)
    yield case("Normal", "Dot", {"Normal": "A"}, direction=tilt)


def color_cases():
    for mode in enum("Mix", "blend_type"):
        links = {"Factor_Float": "C.x", "A_Color": "A", "B_Color": "B"}
        yield case("Mix", "Result_Color", links, JUMPY, low=-0.3, high=1.5, data_type="RGBA", blend_type=mode)
    links = {"Factor_Float": "C.x", "A_Color": "A", "B_Color": "B"}
    yield case("Mix", "Result_Color", links, data_type="RGBA", clamp_factor=False, clamp_result=True)
    for clamp in (False, True):
        links = {"Factor_Float": "C.x", "A_Float": "A.x", "B_Float": "B.x"}
        yield case("Mix", "Result_Float", links, data_type="FLOAT", clamp_factor=clamp)
        links = {"Factor_Float": "C.x", "A_Vector": "A", "B_Vector": "B"}
        yield case("Mix", "Result_Vector", links, data_type="VECTOR", clamp_factor=clamp)
        links = {"Factor_Vector": "C", "A_Vector": "A", "B_Vector": "B"}
        yield case(
            "Mix", "Result_Vector", links, data_type="VECTOR", factor_mode="NON_UNIFORM", clamp_factor=clamp
        )
    for mode in ("MIX", "MULTIPLY", "ADD"):
        for clamp in (False, True):
            links = {"Fac": "C.x", "Color1": "A", "Color2": "B"}
            yield case("MixRGB", "Color", links, blend_type=mode, use_clamp=clamp)
    hsv = {"Hue": "B.x", "Saturation": "B.y", "Value": "B.z", "Fac": "C.x", "Color": "A"}
    yield case("HueSaturation", "Color", hsv, JUMPY, low=0.0, high=1.5)
    yield case("Invert", "Color", {"Fac": "B.x", "Color": "A"})
    yield case("Gamma", "Color", {"Gamma": "B.x", "Color": "A"})
    yield case("BrightContrast", "Color", {"Bright": "B.x", "Contrast": "B.y", "Color": "A"})
    yield case("RGBToBW", "Val", {"Color": "A"})
    for mode in enum("SeparateColor", "mode"):
        for output in ("Red", "Green", "Blue"):
            yield case("SeparateColor", output, {"Color": "A"}, JUMPY, low=-0.2, high=1.5, mode=mode)
        links = {"Red": "A.x", "Green": "B.x", "Blue": "C.x"}
        yield case("CombineColor", "Color", links, JUMPY, low=-0.5, high=1.5, mode=mode)
    yield case("Blackbody", "Color", {"Temperature": "A.x"}, low=200.0, high=14000.0)
    yield case("Wavelength", "Color", {"Wavelength": "A.x"}, low=360.0, high=800.0)


def ramp(mode, interpolation, hue="NEAR"):
    """Sets a ramp of four colours."""

    def make(node):
        r = node.color_ramp
        r.color_mode, r.interpolation, r.hue_interpolation = mode, interpolation, hue
        r.elements[0].position, r.elements[1].position = 0.1, 0.9
        r.elements[0].color, r.elements[1].color = (0.9, 0.1, 0.2, 1), (0.2, 0.3, 0.9, 0.5)
        r.elements.new(0.4).color = (0.1, 0.8, 0.3, 0.7)
        r.elements.new(0.6).color = (0.7, 0.6, 0.1, 1)

    return make


def bend(node):
    """Sets curves of three points per channel."""
    for k, curve in enumerate(node.mapping.curves):
        curve.points.new(0.3, 0.55 - 0.1 * k)
        curve.points.new(0.7, 0.5 + 0.1 * k)
    node.mapping.update()


def table_cases():
    for interpolation in ("LINEAR", "CONSTANT", "EASE", "CARDINAL", "B_SPLINE"):
        jumps = 0.05 if interpolation == "CONSTANT" else 0.0
        links = {"Fac": "A.x"}
        for output in ("Color", "Alpha"):
            settings = {"ramp": ramp("RGB", interpolation), "label": interpolation}
            yield case("ValToRGB", output, links, jumps, low=-0.2, high=1.2, **settings)
    for mode in ("HSV", "HSL"):
        for hue in ("NEAR", "FAR", "CW", "CCW"):
            settings = {"ramp": ramp(mode, "LINEAR", hue), "label": f"{mode} {hue}"}
            yield case("ValToRGB", "Color", {"Fac": "A.x"}, low=-0.2, high=1.2, **settings)
    yield case("RGBCurve", "Color", {"Fac": "B.x", "Color": "A"}, curves=bend)
    yield case("VectorCurve", "Vector", {"Fac": "B.x", "Vector": "A"}, curves=bend)
    yield case("FloatCurve", "Value", {"Factor": "B.x", "Value": "A.x"}, curves=bend)


def pattern_cases():
    for output in ("Color", "Fac"):
        links = {"Vector": "A", "Color1": "B", "Color2": "C", "Scale": 5.0}
        yield case("TexChecker", output, links, JUMPY)
        yield case(
            "TexMagic", output, {"Vector": "A", "Scale": "B.x", "Distortion": "C.x"}, turbulence_depth=10
        )
        yield case("TexMagic", output, {"Vector": "A"}, turbulence_depth=3)
        yield case("TexBrick", output, links | {"Mortar": "D", "Mortar Smooth": 0.4, "Bias": 0.1}, JUMPY)
        yield case(
            "TexBrick",
            output,
            {"Vector": "A", "Mortar Size": 0.1, "Mortar Smooth": 0.0, "Brick Width": 0.7, "Row Height": 0.4},
            0.05,
            offset=0.3,
            squash=0.6,
            offset_frequency=3,
            squash_frequency=2,
        )
        for dimensions in ("1D", "2D", "3D", "4D"):
            socket = {"Color": "Color", "Fac": "Value"}[output]
            links = {"Vector": "A", "W": "B.x"}
            yield case("TexWhiteNoise", socket, links, noise_dimensions=dimensions)
    for kind in enum("TexGradient", "gradient_type"):
        yield case("TexGradient", "Fac", {"Vector": "A"}, gradient_type=kind)
    wave = {"Vector": "A", "Scale": 1.5, "Phase Offset": "B.x", "Distortion": "C.x"}
    for profile in enum("TexWave", "wave_profile"):
        for direction in enum("TexWave", "bands_direction"):
            yield case("TexWave", "Fac", wave, JUMPY, wave_profile=profile, bands_direction=direction)
        for direction in enum("TexWave", "rings_direction"):
            settings = {"wave_type": "RINGS", "wave_profile": profile, "rings_direction": direction}
            yield case("TexWave", "Color", wave, JUMPY, **settings)


def noise_cases():
    for dimensions in ("1D", "2D", "3D", "4D"):
        links = {"Vector": "A", "W": "B.x", "Scale": 3.0, "Detail": 3.5, "Roughness": 0.6, "Distortion": 0.4}
        for kind in enum("TexNoise", "noise_type"):
            links = links | {"Offset": 0.3, "Gain": 1.3, "Lacunarity": 2.1}
            settings = {"noise_dimensions": dimensions, "noise_type": kind}
            yield case("TexNoise", "Fac", links, **settings)
            if kind in ("FBM", "MULTIFRACTAL"):
                # green and blue are looked up 100 to 200 units away: the last bit of a coordinate shows
                yield case("TexNoise", "Color", links, JUMPY, normalize=False, **settings)
    varied = {"Vector": "A", "Scale": "B.x", "Detail": "C.x", "Roughness": "C.y", "Distortion": "D.x"}
    yield case("TexNoise", "Color", varied, high=4.0, label="varied")
    far = {"Vector": "A", "Scale": 1.0}
    yield case("TexNoise", "Fac", far, low=-3e5, high=3e5, label="far away")


def voronoi_cases():
    for dimensions in ("1D", "2D", "3D", "4D"):
        links = {"Vector": "A", "W": "B.x", "Scale": 2.0, "Randomness": 0.8, "Smoothness": 0.7}
        for feature in enum("TexVoronoi", "feature"):
            if dimensions == "4D" and feature == "SMOOTH_F1":
                continue
            settings = {"voronoi_dimensions": dimensions, "feature": feature}
            outputs = {"DISTANCE_TO_EDGE": ("Distance",), "N_SPHERE_RADIUS": ("Radius",)}.get(
                feature, ("Distance", "Color")
            )
            for output in outputs:
                yield case("TexVoronoi", output, links, JUMPY, **settings)
    for metric in ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
        settings = {"distance": metric, "normalize": True}
        yield case("TexVoronoi", "Distance", {"Vector": "A", "Exponent": 1.7}, JUMPY, **settings)
        yield case("TexVoronoi", "Position", {"Vector": "A", "Exponent": 1.7}, JUMPY, **settings)
    for feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE"):
        links = {"Vector": "A", "Detail": 2.3, "Roughness": 0.6, "Lacunarity": 1.9}
        settings = {"feature": feature, "normalize": True, "voronoi_dimensions": "2D"}
        yield case("TexVoronoi", "Distance", links, JUMPY, **settings)
    yield case("TexVoronoi", "W", {"W": "A.x"}, JUMPY, voronoi_dimensions="1D")


CASES = [
    *math_cases(),
    *vector_cases(),
    *color_cases(),
    *table_cases(),
    *pattern_cases(),
    *noise_cases(),
    *voronoi_cases(),
]


@pytest.fixture(scope="module")
def answers():
    """Cycles' and our values of every case, from one render: id → (3, n) pair."""
    empty_scene()
    tables, materials = [], []
    for number, row in enumerate(CASES):
        c = row.values[0]
        table = cycles_nodes.inputs(number, *c.bounds)
        sheet = cycles_nodes.sheet(c.name, table, *cycles_nodes.place(number, len(CASES)))
        material = cycles_nodes.material(c.name, c.kind, c.settings, c.links, c.output)
        sheet.data.materials.append(material)
        tables.append(table)
        materials.append(material)
    picture = cycles_nodes.render(len(CASES))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([])
    graphs = [export_material(m.evaluated_get(depsgraph), images) for m in materials]
    compiled = compile_materials(graphs)
    found = []
    for number in range(len(CASES)):
        batch = compiled.batches[compiled.batch_of[number]]
        ours = batch.emission(NodeLanes(colors=tables[number], material=number))
        if ours is None:
            ours = np.zeros((3, 1), np.float32)
        theirs = cycles_nodes.cut(picture, number, len(CASES))
        found.append((theirs, np.broadcast_to(ours, theirs.shape)))
    return found, compiled


@pytest.mark.parametrize("number", [pytest.param(k, id=row.id) for k, row in enumerate(CASES)])
def test_node_gives_what_cycles_gives(number, answers):
    theirs, ours = answers[0][number]
    assert ours.dtype == np.float32
    error = np.abs(ours - theirs) / (np.abs(theirs) + 0.01)
    wrong = ~(error <= 1e-4).all(axis=0)
    allowed = CASES[number].values[0].jumps * wrong.size
    worst = int(np.nan_to_num(error, nan=np.inf).max(axis=0).argmax())
    assert wrong.sum() <= allowed, (
        f"{wrong.sum()} of {wrong.size} pixels differ, the worst by {error[:, worst].max():.2g}: "
        f"{ours[:, worst]} instead of {theirs[:, worst]}"
    )


def test_cases_are_not_trivial(answers):
    flat = [CASES[k].id for k, (theirs, _) in enumerate(answers[0]) if np.ptp(theirs) == 0]
    assert flat == []
