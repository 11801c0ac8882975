"""Directional albedo of every closure, ours beside Cycles': patches of a plane under a white sky.

A plane sees nothing of itself, so a patch shows what its closure scatters toward the camera in all: E(θ).
Ours is E by quadrature over the compiled closures' samplers. Kinds and settings are those of this
Blender; of the inputs, each that is a number is tried at some values, one at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene, mesh
from support.bsdf_checks import LARGEST
from support.closures import compiled_closures
from support.cycles import by_cycles

from pt_engine.blender.export.images import ImageTable
from pt_engine.blender.export.materials import export_material
from pt_engine.core import frames
from pt_engine.nodes import catalogue  # noqa: F401  (fills the registry)
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.registry import SHADERS
from pt_engine.scene.snapshot import Graph

from .cases import accepted, combinations, kinds
from .measure import worst

COLOR = (0.8, 0.4, 0.1, 1.0)
PIXELS = 4  # along a patch; no render of Blender is smaller
ROUGHNESS = (0.0, 0.1, 0.3, 0.6, 1.0)
VALUES = {
    "Roughness": ROUGHNESS,
    "IOR": (1.0, 1.1, 2.0, 0.7),
    "Anisotropy": (0.8, -0.5),
    "Rotation": (0.3,),
    "Thin Film Thickness": (400.0,),
    "Size": (0.2, 0.9),
    "Smooth": (0.0, 0.7),
}
AT_HAND = {"Roughness": 0.3, "Anisotropy": 0.0}  # what the other inputs are meanwhile
ELSEWHERE = {
    "Emission": "it scatters nothing",
    "Background": "it scatters nothing",
    "BsdfRayPortal": "it moves rays",
    "BsdfPrincipled": "tests/blender/test_principled_against_cycles.py",
    "MixShader": "see the spheres",
    "AddShader": "see the spheres",
}


class Patch(NamedTuple):
    """A closure: its kind, settings, and the input that is not at hand with its value."""

    kind: str
    settings: tuple[tuple[str, Any], ...]
    inputs: tuple[tuple[str, float], ...]

    @property
    def name(self) -> str:
        words = [self.kind, *(str(v) for _, v in self.settings), *(f"{k} {v:g}" for k, v in self.inputs)]
        return " ".join(words)


def patches(only: Sequence[str] = ()) -> list[Patch]:
    """All patches, or those of some kinds."""
    wanted = [k for k in kinds() if k in SHADERS and k not in ELSEWHERE and (not only or k in only)]
    return [patch for kind in wanted for patch in patches_of(kind)]


def patches_of(kind: str) -> Iterator[Patch]:
    """The patches of a kind, under every combination of its settings."""
    tree = bpy.data.node_groups.new("patches", "ShaderNodeTree")
    node = tree.nodes.new("ShaderNode" + kind)
    for settings in combinations(kind):
        if not accepted(node, settings):
            continue
        names = [s.identifier for s in node.inputs if s.type == "VALUE" and not s.is_unavailable]
        tried = [(name, value) for name in names for value in VALUES.get(name, ())]
        for one in [(name, value) for name, value in tried] or [()]:
            yield Patch(kind, tuple(settings.items()), (one,) if one else ())
    bpy.data.node_groups.remove(tree)


@dataclass(frozen=True)
class Reflected:
    """A patch's albedo at an angle.

    Attributes
    ----------
    cos : float
    ours, theirs, noise : (3,) float64
        `noise` is the standard error of `theirs`.
    """

    patch: Patch
    cos: float
    state: str
    effect: str
    ours: NDArray[np.float64]
    theirs: NDArray[np.float64]
    noise: NDArray[np.float64]

    @property
    def error(self) -> float:
        """Largest |ours − Cycles| / max(Cycles, 0.05) of the channels."""
        return float((np.abs(self.ours - self.theirs) / np.maximum(self.theirs, 0.05)).max())

    @property
    def sigma(self) -> float:
        """Noise of the same."""
        return float((self.noise / np.maximum(self.theirs, 0.05)).max())


def reflected(
    every: Sequence[Patch], cosines: Sequence[float], samples: int, folder: Path, points: int = 1 << 16
) -> list[Reflected]:
    """Albedos of all patches at all angles; one pair of renders per angle."""
    empty_scene()
    sky = bpy.data.worlds.new("White")
    background = with_nodes(sky).nodes.new("ShaderNodeBackground")
    end = sky.node_tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    sky.node_tree.links.new(background.outputs[0], end.inputs["Surface"])
    bpy.context.scene.world = sky
    materials = [material(patch) for patch in every]
    graphs = exported(materials)
    states = [worst(compile_materials([graph]).coverage) for graph in graphs]
    found = []
    for cos in cosines:
        theirs, noise = pictured(materials, cos, samples, folder)
        sine = math.sqrt(1 - cos * cos)
        wi = np.array([[0.0], [-sine], [cos]], np.float32)
        for k, patch in enumerate(every):
            ours = albedo(graphs[k], wi, points)
            found.append(Reflected(patch, cos, *states[k], ours, theirs[k], noise[k]))
    return found


def albedo(graph: Graph, wi: NDArray[np.float32], points: int) -> NDArray[np.float64]:
    """(3,) ∫ f·|cosθo| dωo of a material over the normal +Z: its closures' samplers on Kronecker's lattice.

    The lattice's error falls almost as 1/points even where some samples fail, at the horizon; a grid's
    does not.
    """
    total: NDArray[np.float64] = np.zeros(3)
    u = lattice(points)
    up = np.array([[0.0], [0.0], [1.0]], np.float32)
    for closure in compiled_closures(graph, wi):
        local = wi
        if closure.tangent is not None:
            local = frames.to_local(*frames.from_tangent(up, closure.tangent), up, wi)
        weight = closure.bsdf.sample(closure.params, np.repeat(local, points, axis=1), *u).weight
        total += closure.weight.mean(axis=-1) * weight.mean(axis=-1, dtype=np.float64)
    return total


def lattice(points: int) -> NDArray[np.float32]:
    """(3, points) multiples of the powers of 1/g, g⁴ = g + 1, modulo 1."""
    g = 1.2207440846057596
    steps = np.arange(1, points + 1, dtype=np.float64)
    return np.minimum(np.stack([steps * g**-k % 1.0 for k in (1, 2, 3)]).astype(np.float32), LARGEST)


def material(patch: Patch) -> Any:
    """The patch's closure on its own."""
    made = bpy.data.materials.new(patch.name)
    tree = with_nodes(made)
    node, end = tree.nodes.new("ShaderNode" + patch.kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in patch.settings:
        setattr(node, name, value)
    sockets = {s.identifier: s for s in node.inputs}
    for name in ("Color", "Base Color"):
        if name in sockets:
            sockets[name].default_value = COLOR
    if "Tangent" in sockets:
        along = tree.nodes.new("ShaderNodeCombineXYZ")
        along.inputs["Y"].default_value = 1.0
        tree.links.new(along.outputs[0], sockets["Tangent"])
    for name, value in (AT_HAND | dict(patch.inputs)).items():
        if name in sockets:
            sockets[name].default_value = value
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return made


def exported(materials: Sequence[Any]) -> list[Graph]:
    """The graphs of materials, as a render sees them."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return [export_material(m.evaluated_get(depsgraph), ImageTable([])) for m in materials]


def pictured(
    materials: Sequence[Any], cos: float, samples: int, folder: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(M, 3) albedo in Cycles' picture, and its standard error, seen at an angle; squares in one row."""
    scene, m = bpy.context.scene, len(materials)
    corners = [(x, y / cos, 0) for x in range(m + 1) for y in (0, 1)]
    plane = mesh(corners, [(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(m)], f"Plane {cos}")
    for made in materials:
        plane.materials.append(made)
    plane.polygons.foreach_set("material_index", np.arange(m, dtype=np.int32))
    owner = add(plane)
    sine, camera = math.sqrt(1 - cos * cos), scene.camera
    camera.data.type, camera.data.ortho_scale, camera.data.clip_end = "ORTHO", m, 1e4
    camera.location = (m / 2, 0.5 / cos - 500 * sine, 500 * cos)
    camera.rotation_euler = (math.acos(cos), 0, 0)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01  # no light from the neighbours
    pair = np.stack(by_cycles(samples, (PIXELS * m, PIXELS), folder)).astype(np.float64)[..., :3]
    bpy.data.objects.remove(owner)
    pixels = pair.reshape(2, PIXELS, m, PIXELS, 3).transpose(2, 0, 1, 3, 4).reshape(m, -1, 3)
    return pixels.mean(axis=1), pixels.std(axis=1, ddof=1) / math.sqrt(pixels.shape[1])
