"""The Principled as it renders against Cycles: a plane in a white furnace shows what it reflects in all.

Pixels are the directional albedo, as nothing is hit a second time; ours is added up over the closures of
the same material, exported and compiled. Cycles' noise at 65,536 samples is below 0.1 %; its tables were
made by random numbers, ours by quadrature, and differ by less than 0.1 % but where glass is left; and
anisotropy leaves the quadrature's 0.3 %. Hence 0.4 %.
"""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, empty_scene, export, mesh  # noqa: E402
from support.bsdf_checks import f32  # noqa: E402
from support.closures import furnace_albedo  # noqa: E402
from support.cycles import by_cycles  # noqa: E402

from pt_engine.nodes.compile import compile_materials  # noqa: E402
from pt_engine.nodes.coverage import EXACT  # noqa: E402
from pt_engine.nodes.shaders import MORE_LIGHT_IN_CYCLES  # noqa: E402

COLOR = (0.8, 0.4, 0.1)
CASES = [
    {},
    {"Roughness": 0.2},
    {"Roughness": 1.0, "IOR": 2.0},
    {"Roughness": 0.4, "IOR": 0.8},
    {"Metallic": 1.0, "Roughness": 0.7},
    {"Metallic": 1.0, "Roughness": 0.4, "Specular Tint": (0.2, 0.6, 1.0)},
    {"Metallic": 1.0, "Roughness": 0.5, "Anisotropic": 0.8},
    {"Specular IOR Level": 1.0, "Specular Tint": (1.0, 0.5, 0.2), "Roughness": 0.4},
    {"Transmission Weight": 1.0, "Roughness": 0.5},
    {"Transmission Weight": 1.0, "Roughness": 0.8, "IOR": 1.2, "Specular Tint": (0.3, 0.6, 1.0)},
    {"Transmission Weight": 0.6, "Metallic": 0.3, "Roughness": 0.3},
    {"Coat Weight": 0.8, "Coat Roughness": 0.3, "Coat Tint": (0.9, 0.6, 0.3)},
    {"Coat Weight": 1.0, "Metallic": 1.0, "Roughness": 0.5, "Coat IOR": 1.8},
    {"Diffuse Roughness": 0.7, "IOR": 1.0},
    {"Sheen Weight": 1.0, "Sheen Roughness": 0.3, "Metallic": 1.0},
    {"Sheen Weight": 0.7, "Sheen Roughness": 0.8, "Sheen Tint": (0.9, 0.5, 0.1), "Coat Weight": 0.5},
]
PLACE = 100.0  # along x: about the origin the default tangent goes round, so here it lies along y


@pytest.fixture(scope="module")
def furnace():
    """A vast plane under a white sky, seen from straight ahead by a parallel camera."""
    scene = empty_scene()
    sky, made = bpy.data.worlds.new("White"), bpy.data.materials.new("Principled")
    for owner in (sky, made):
        if owner.node_tree is None:
            owner.use_nodes = True
    background = next(n for n in sky.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    scene.world = sky
    plane = mesh([(-500, -500, 0), (500, -500, 0), (500, 500, 0), (-500, 500, 0)], [(0, 1, 2, 3)])
    plane.materials.append(made)
    add(plane)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.1
    node = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    return scene, node, {s.name: value_of(s) for s in node.inputs if not s.is_unavailable}


def value_of(socket):
    """A socket's value, of a colour or a vector as a tuple."""
    value = socket.default_value
    return value if isinstance(value, bool | int | float) else tuple(value)


def set_sockets(node, defaults, sockets):
    """The node as it is by default, but for some sockets."""
    for name, value in (defaults | {"Base Color": COLOR} | sockets).items():
        old = node.inputs[name].default_value
        colored = isinstance(value, tuple) and len(value) < len(old)
        node.inputs[name].default_value = (*value, 1.0) if colored else value


def exported_material():
    """The plane's material as the snapshot has it."""
    snapshot = export()
    _, *own = snapshot.materials  # the first is the default surface, a Principled too
    (graph,) = (m for m in own if any(n.kind == "BsdfPrincipled" for n in m.nodes))
    return graph


@pytest.mark.parametrize("cos", [0.95, 0.3])
@pytest.mark.parametrize("case", CASES, ids=lambda case: " ".join(case) or "default")
def test_reflects_as_much_as_in_cycles(furnace, case, cos, tmp_path):
    scene, node, defaults = furnace
    set_sockets(node, defaults, case)
    sine = math.sqrt(1 - cos * cos)
    scene.camera.location = (PLACE, -100 * sine, 100 * cos)
    scene.camera.rotation_euler = (math.acos(cos), 0.0, 0.0)
    theirs = np.mean(by_cycles(2048, (4, 4), tmp_path), axis=(0, 1, 2))[:3]
    graph = exported_material()
    ours = furnace_albedo(graph, f32(0.0, -sine, cos), position=f32(PLACE, 0.5, 0.0))
    np.testing.assert_allclose(ours, theirs, rtol=4e-3)
    inexact = {entry.effect for entry in compile_materials([graph]).coverage if entry.state != EXACT}
    assert inexact <= {MORE_LIGHT_IN_CYCLES}  # of lamps, of which there are none here
