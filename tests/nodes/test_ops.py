"""Every op gives float32, whatever its settings: float64 would double the cost of all that follows.

Each node kind is compiled with *every* input linked to a colour attribute, so that nothing folds, for
every setting that chooses another formula; then its ops run one by one on a few fake lanes.
"""

from __future__ import annotations

import importlib
import itertools
import pkgutil
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from support.node_lanes import NodeLanes

from pt_engine import nodes
from pt_engine.nodes import color_nodes, coordinates, ir, light_path, math_nodes, vector_nodes, voronoi_nodes
from pt_engine.nodes.compile import catalogue  # noqa: F401  (fills the registry)
from pt_engine.nodes.coverage import CoverageLog
from pt_engine.nodes.displacement import displaced_normal
from pt_engine.nodes.graph import GraphReader, NodeView
from pt_engine.nodes.program import ordered_calls
from pt_engine.nodes.registry import NODES, SHADERS
from pt_engine.nodes.surface import SurfaceBuilder
from pt_engine.scene.snapshot import Graph, ImageData, Link, Node
from pt_engine.textures.images import TextureStore

LANES = 7
BOTH = (False, True)
DIMENSIONS = ("1D", "2D", "3D", "4D")
CURVES = tuple(tuple(np.linspace(0, 1, 8).tolist()) for _ in range(3))
FOLDED = ((0.0, 1.0, 0.0, -1.0, 1.0, 2.0, 0.0, 0.4, 1.0),) * 4
RAMPS = [("RGB", kind, ((0.1, 0, 0, 0, 1), (0.9, 1, 1, 1, 0.5))) for kind in ("LINEAR", "CONSTANT")]
CANDLE = "IESNA\nTILT=NONE\n1 100 1 3 1 1 1 0 0 0 1 1 5\n0 90 180\n0\n3 2 1\n"
SPACES = ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")
MAPPING = {
    "mapping_x": "Y",
    "mapping_y": "X",
    "mapping_z": "NONE",
    "vector_type": "TEXTURE",
    "scale": (0, 1, 2),
    "rotation": (0, 0, 1),
}


class Linked(dict):
    """A node's inputs, each of which is linked to the attribute, but those that are `left` alone."""

    def __init__(self, left: tuple[str, ...] = ()) -> None:
        super().__init__()
        self.left = left

    def get(self, name: str, default: Any = None) -> Any:
        return None if name in self.left else Link(0, "Color")

    def __contains__(self, name: object) -> bool:
        return name not in self.left


def settings(**choices: Any) -> list[dict[str, Any]]:
    """All combinations of a node's settings."""
    values = (v if isinstance(v, list | tuple | set | dict) else [v] for v in choices.values())
    return [dict(zip(choices, some, strict=True)) for some in itertools.product(*values)]


GLOSSY = settings(distribution=("GGX", "MULTI_GGX", "BECKMANN"))
HAIR = settings(parametrization=("COLOR", "MELANIN", "ABSORPTION"), model=("CHIANG", "HUANG"))
SETTINGS: dict[str, list[dict[str, Any]]] = {
    "BsdfHairPrincipled": HAIR,
    "Math": settings(operation=math_nodes.MATH, use_clamp=True),
    "VectorMath": settings(operation=vector_nodes.VECTOR_MATH),
    "MapRange": settings(
        interpolation_type=("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"),
        data_type=("FLOAT", "FLOAT_VECTOR"),
        clamp=BOTH,
    ),
    "Clamp": settings(clamp_type=("MINMAX", "RANGE")),
    "Mapping": settings(vector_type=("POINT", "TEXTURE", "VECTOR", "NORMAL")),
    "VectorRotate": settings(rotation_type=("AXIS_ANGLE", "X_AXIS", "EULER_XYZ"), invert=BOTH),
    "VectorTransform": settings(vector_type=("VECTOR", "POINT", "NORMAL"), convert_to=("WORLD", "OBJECT"))
    + settings(vector_type=("VECTOR", "POINT", "NORMAL"), convert_from="OBJECT", convert_to="WORLD"),
    "Mix": settings(data_type="RGBA", blend_type=color_nodes.BLENDS, clamp_result=True)
    + settings(data_type=("FLOAT", "VECTOR"), factor_mode=("UNIFORM", "NON_UNIFORM")),
    "MixRGB": settings(blend_type=color_nodes.BLENDS, use_clamp=True),
    "SeparateColor": settings(mode=("RGB", "HSV", "HSL")),
    "CombineColor": settings(mode=("RGB", "HSV", "HSL")),
    **dict.fromkeys(("Blackbody", "RGBToBW"), settings(folded=BOTH)),
    "ValToRGB": settings(ramp=RAMPS, folded=BOTH),
    **dict.fromkeys(
        ("RGBCurve", "VectorCurve", "FloatCurve"),
        settings(curves=[CURVES], curve_extend=("HORIZONTAL", "EXTRAPOLATED"))
        + settings(folded_curves=[FOLDED], folded_clip=[(0.1, 0.5)]),
    ),
    "TexChecker": [{}, {"texture_mapping": MAPPING}],
    "TexGradient": settings(
        gradient_type=(
            "LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "SPHERICAL", "QUADRATIC_SPHERE",
        )
    ),
    "TexMagic": settings(turbulence_depth=(0, 2, 10)),
    "TexWhiteNoise": settings(noise_dimensions=DIMENSIONS),
    "TexNoise": settings(
        noise_dimensions=DIMENSIONS,
        noise_type=(
            "FBM", "MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "HETERO_TERRAIN",
        ),
        normalize=BOTH,
    ),
    "TexWave": settings(
        wave_type="BANDS", bands_direction=("X", "DIAGONAL"), wave_profile=("SIN", "SAW", "TRI")
    )
    + settings(wave_type="RINGS", rings_direction=("X", "SPHERICAL")),
    "TexVoronoi": settings(
        feature=voronoi_nodes.FEATURES,
        voronoi_dimensions=DIMENSIONS,
        distance=("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"),
        normalize=True,
    ),
    "TexImage": settings(
        image=0,
        interpolation=("Linear", "Closest", "Cubic"),
        projection=("FLAT", "SPHERE", "TUBE", "BOX"),
        projection_blend=0.3,
    ),
    "TexEnvironment": settings(image=0, projection=("EQUIRECTANGULAR", "MIRROR_BALL")),
    "TexSky": settings(sky_type=("SINGLE_SCATTERING", "MULTIPLE_SCATTERING", "PREETHAM", "HOSEK_WILKIE")),
    "TexIES": settings(ies_text=("", CANDLE)),
    "NormalMap": settings(space=SPACES, convention=("OPENGL", "DIRECTX")),
    "Bump": settings(invert=BOTH),
    "Displacement": settings(space=("OBJECT", "WORLD")),
    "VectorDisplacement": settings(space=("TANGENT", "OBJECT", "WORLD")),
    "Tangent": settings(axis=("X", "Y", "Z")) + [{"direction_type": "UV_MAP"}],
    "TexCoord": settings(object_matrix=[None, tuple(np.eye(4).ravel().tolist())], from_instancer=BOTH),
    "Wireframe": settings(use_pixel_size=BOTH),
    "Attribute": settings(attribute_name=["A", "tangent_sign"], attribute_type=("GEOMETRY", "OBJECT")),
    "BsdfGlossy": GLOSSY,
    "BsdfGlass": GLOSSY,
    "BsdfMetallic": settings(fresnel_type=("F82", "PHYSICAL_CONDUCTOR"), distribution="MULTI_GGX"),
    "BsdfPrincipled": GLOSSY,
    "BsdfToon": settings(component=("DIFFUSE", "GLOSSY")),
    "BsdfSheen": settings(distribution=("MICROFIBER", "ASHIKHMIN")),
    "PtRoughPlastic": settings(nonlinear=BOTH),
}  # fmt: skip
# of the nodes that compute only what some link reads
OUTPUTS = {
    *("Generated", "Normal", "UV", "Object", "Reflection", "Camera", "Window"),
    *("View Vector", "View Z Depth", "Index", "Age", "Lifetime", "Size", "Velocity"),
    *("Position", "Tangent", "Tangent Normal", "True Normal", "Incoming", "Parametric", "Backfacing"),
    *("Pointiness", "Random Per Island"),
    *("Color", "Alpha", "Location", "Object Index", "Random", "Value", "Dot"),
    *("Ray Length", "Ray Depth", "Transparent Depth", "Diffuse Depth", *light_path.KINDS),
    *("Fac", "Fresnel", "Facing", "Quadratic", "Linear", "Constant"),
}
ISOTROPIC = ("Normal", "Tangent", "Anisotropic", "Anisotropy", "Coat Normal", "Vector", "Specular Tint")
CASES = [
    pytest.param(kind, left, props, id=" ".join([kind, *map(str, props.values()), *left[:1]])[:80])
    for kind in (*NODES, *SHADERS)
    for props in SETTINGS.get(kind, [{}])
    for left in ((), ISOTROPIC)
]
CASES += [
    pytest.param("BsdfPrincipled", ("Normal",), {}, id="BsdfPrincipled, its coat alone has a normal"),
    pytest.param("BsdfHairPrincipled", ("Random",), {}, id="BsdfHairPrincipled, its Random the strands' own"),
]


def reader() -> GraphReader:
    """A reader of a graph of one colour attribute."""
    pixels = np.random.default_rng(0).random((4, 4, 4), np.float32)
    store = TextureStore([ImageData("picture", pixels=pixels)])
    attribute = Node("VertexColor", "attribute", {}, {"layer_name": "A"})
    return GraphReader(Graph("test", (attribute,), {}), ir.Builder(), store, CoverageLog("test"))


def values_of(kind: str, left: tuple[str, ...], props: dict[str, Any]) -> list[ir.Value]:
    """All that a node gives: values, or everything about its closures."""
    known = reader()
    known.used[1] = OUTPUTS
    view = NodeView(known, 1, Node(kind, kind, Linked(left), props), 0)
    if kind in NODES:
        return [value for value in NODES[kind](view).values() if value is not None]
    out = SurfaceBuilder(known.builder)
    weight = known.builder.convert(view.color("Weight"), ir.FLOAT)
    if "Shader" in kind:  # Mix and Add only pass weights on
        return [weight]
    SHADERS[kind](view, weight, out)
    found = [
        v
        for leaf in out.leaves
        for v in (leaf.weight, leaf.normal, leaf.tangent, *dict(leaf.params).values())
    ]
    return [v for v in (*found, out.emission, out.transparency, out.holdout) if v is not None]


def ran(roots: list[ir.Value]) -> Iterator[tuple[ir.Op, str, Any]]:
    """Each op that `roots` need with the type and the array of each of its outputs."""
    rng = np.random.default_rng(1)
    wi = np.abs(rng.normal(size=(3, LANES))).astype(np.float32)
    lanes = NodeLanes(
        colors={"A": rng.uniform(-0.5, 1.5, (3, LANES)).astype(np.float32)},
        position=rng.uniform(-2, 2, (3, LANES)).astype(np.float32),
        wi=wi / np.sqrt((wi * wi).sum(axis=0)),
    )
    results: dict[int, tuple[Any, ...]] = {}
    for call in ordered_calls(roots):
        arrays = [a.data if isinstance(a, ir.Const) else results[id(a.call)][a.index] for a in call.args]
        here = [lanes.shifted(*ir.shift_of(call.shift)) if call.shift else lanes] if call.op.lanes else []
        with np.errstate(all="ignore"):
            out = call.op.function(*here, *call.static, *arrays)
        results[id(call)] = out if len(call.op.types) > 1 else (out,)
        for kind, array in zip(call.op.types, results[id(call)], strict=True):
            yield call.op, kind, array


@pytest.mark.parametrize(("kind", "left", "props"), CASES)
def test_op_gives_float32(kind: str, left: tuple[str, ...], props: dict[str, Any]) -> None:
    for what, of, array in ran(values_of(kind, left, props)):
        assert array.dtype == np.float32, f"{what.name} gives {array.dtype}"
        rows = () if of == ir.FLOAT else (3,)
        assert array.shape in ((*rows, LANES), (*rows, 1)), f"{what.name} gives {array.shape}"


def all_ops() -> set[ir.Op]:
    """Every op that a file of `nodes` makes."""
    found: set[ir.Op] = set()
    for module in pkgutil.iter_modules(nodes.__path__):
        for thing in vars(importlib.import_module(f"{nodes.__name__}.{module.name}")).values():
            members = thing.values() if isinstance(thing, dict) else [thing]
            found |= {m for m in members if isinstance(m, ir.Op)}
    return found


def conversions() -> list[ir.Value]:
    """What no node kind asks for: conversions and sums of all types, displacement as bump, Shader to RGB."""
    known = reader()
    b, color = known.builder, known.value(Link(0, "Color"), 0)
    assert color is not None
    types = (ir.FLOAT, ir.VECTOR, ir.COLOR)
    values = [b.convert(color, t) for t in types]
    values += [b.convert(v, t) for v in values for t in types]
    made = [f(x, x) for f in (b.add, b.multiply) for x in values]
    made += [b.complement(x) for x in values]
    height = Node("Displacement", "up", Linked(), {})
    raised = GraphReader(
        Graph("test", (known.graph.nodes[0], height), {}), b, known.textures, CoverageLog("test")
    )
    normal = displaced_normal(raised, Link(1, "Displacement"))
    assert normal is not None
    shine = Node("ShaderToRGB", "to rgb", {"Shader": Link(1, "BSDF")})
    lit = GraphReader(
        Graph("test", (known.graph.nodes[0], Node("BsdfSheen", "sheen", Linked(), {}), shine), {}),
        b,
        known.textures,
        CoverageLog("test"),
    ).value(Link(2, "Color"), 0)
    assert lit is not None
    direction = b.call(vector_nodes.normalized, values[1])  # of the Normal node, which always folds
    part = b.call(ir.first_component, values[2])  # programs put it in, not nodes, as they do the next
    inputs = [values[1], *values[:1] * 8]
    distance = b.call(voronoi_nodes.voronoi_distance, *inputs, static=("F2", "EUCLIDEAN", 3, True))
    both = b.call(voronoi_nodes.voronoi_distances, *inputs, static=("EUCLIDEAN", 3, True))
    same = b.call(ir.as_float, values[0])
    at_rest = b.call(coordinates.normal_at_rest, normal)  # where displacement bends and Bumps follow
    return [*at_rest, *values, *made, normal, lit, *direction, *part, *distance, *both, *same]


def test_conversions_give_float32() -> None:
    for what, _, array in ran(conversions()):
        assert array.dtype == np.float32, f"{what.name} gives {array.dtype}"


def test_every_op_is_among_these() -> None:
    roots = [values_of(*case.values) for case in CASES]
    seen = {call.op for group in (*roots, conversions()) for call in ordered_calls(group)}
    assert sorted(op.name for op in all_ops() - seen) == []
