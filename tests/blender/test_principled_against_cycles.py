"""The Principled's layers against Cycles' own: a plane in a white furnace shows what it reflects in all.

Pixels are the directional albedo, as nothing is hit a second time. Cycles' noise at 65,536 samples is
below 0.1 %; its tables were made by random numbers, ours by quadrature, and differ by less than 0.1 % but
where glass is left; and anisotropy leaves the quadrature's 0.3 %. Hence 0.4 %.
"""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import bsdf_checks as checks  # noqa: E402
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.bsdf_checks import direction, f32  # noqa: E402
from support.cycles import by_cycles  # noqa: E402

from pt_engine.bsdfs import principled  # noqa: E402

COLOR = (0.8, 0.4, 0.1)
CASES = [
    {},
    {"roughness": 0.2},
    {"roughness": 1.0, "ior": 2.0},
    {"roughness": 0.4, "ior": 0.8},
    {"metallic": 1.0, "roughness": 0.7},
    {"metallic": 1.0, "roughness": 0.4, "specular_tint": (0.2, 0.6, 1.0)},
    {"metallic": 1.0, "roughness": 0.5, "anisotropic": 0.8},
    {"specular_ior_level": 1.0, "specular_tint": (1.0, 0.5, 0.2), "roughness": 0.4},
    {"transmission_weight": 1.0, "roughness": 0.5},
    {"transmission_weight": 1.0, "roughness": 0.8, "ior": 1.2, "specular_tint": (0.3, 0.6, 1.0)},
    {"transmission_weight": 0.6, "metallic": 0.3, "roughness": 0.3},
    {"coat_weight": 0.8, "coat_roughness": 0.3, "coat_tint": (0.9, 0.6, 0.3)},
    {"coat_weight": 1.0, "metallic": 1.0, "roughness": 0.5, "coat_ior": 1.8},
    {"diffuse_roughness": 0.7, "ior": 1.0},
]


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
    return scene, next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")


def set_sockets(node, sockets):
    """Every socket that we model: the given ones, and our defaults."""
    for name, default in principled.Inputs()._asdict().items():
        value = sockets.get(name, default[:, 0] if default.ndim == 2 else float(default[0]))
        socket = node.inputs[name.replace("_", " ").title().replace("Ior", "IOR")]
        socket.default_value = value if isinstance(value, float) else (*value, 1.0)


def albedo(sockets, cos):
    """What the closures reflect and transmit in all. About the origin the default tangent goes round, so at
    x > 0 it lies along y, as does the view."""
    layers = principled.layers(principled.inputs(**sockets), f32(cos), f32(cos), f32(0.0))
    total = np.zeros(3)
    for layer in layers.closures:
        wi = direction(cos)
        single = checks.directional_albedo(layer.bsdf, layer.params, wi, rows=96)
        total += layer.weight.mean(axis=-1) * single
    return total


@pytest.mark.parametrize("cos", [0.95, 0.3])
@pytest.mark.parametrize("case", CASES, ids=lambda case: " ".join(case) or "default")
def test_reflects_as_much_as_in_cycles(furnace, case, cos, tmp_path):
    scene, node = furnace
    sockets = {"base_color": COLOR} | case
    set_sockets(node, sockets)
    scene.camera.location = (100.0, -100 * math.sin(math.acos(cos)), 100 * cos)
    scene.camera.rotation_euler = (math.acos(cos), 0.0, 0.0)
    theirs = np.mean(by_cycles(2048, (4, 4), tmp_path), axis=(0, 1, 2))[:3]
    np.testing.assert_allclose(albedo(sockets, cos), theirs, rtol=4e-3)
