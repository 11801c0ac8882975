"""A snapshot without one of its effects: what `whatif` renders.

Each effect knows whether a scene has it, and a pure function takes it out. None draws on Blender.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..render.settings import RenderSettings
from ..scene.features import ON
from ..scene.scene import Scene
from ..scene.snapshot import Graph, LightData, Link, Node, Snapshot

TINY = 1e-3  # of a lamp's size: its shadows are hard, and it still shines as it did
GLOSSY = ("BsdfGlossy", "BsdfAnisotropic", "BsdfMetallic")
REFRACTIVE = ("BsdfGlass", "BsdfRefraction")
MATTE = {"Metallic": 0.0, "Specular IOR Level": 0.0, "Coat Weight": 0.0}


@dataclass(frozen=True)
class Effect:
    """Something that can be taken out.

    Attributes
    ----------
    name : str
    missing : callable
        (snapshot, scene, settings) → why the scene has none of it, "" if it has.
    without : callable
        (snapshot, settings) → both without the effect.
    """

    name: str
    missing: Callable[[Snapshot, Scene, RenderSettings], str]
    without: Callable[[Snapshot, RenderSettings], tuple[Snapshot, RenderSettings]]


# ------------------------------------------------------------------ lamps, camera, world


def hard_lamp(lamp: LightData) -> LightData:
    """The same power from (nearly) a point, or from one direction."""
    if lamp.kind == "AREA":
        shrunk = lamp.power if lamp.normalize else lamp.power / TINY**2
        return replace(lamp, size=(lamp.size[0] * TINY, lamp.size[1] * TINY), power=shrunk)
    return replace(lamp, radius=0.0, angle=0.0)


def hard_shadows(snapshot: Snapshot) -> Snapshot:
    """Every lamp without a size; shining meshes stay as they are."""
    return replace(snapshot, lights=tuple(hard_lamp(lamp) for lamp in snapshot.lights))


def has_size(lamp: LightData) -> bool:
    """Whether a lamp's shadows are soft."""
    if lamp.kind == "AREA":
        return True
    return lamp.angle > 0 if lamp.kind == "SUN" else lamp.radius > 0


def pinhole(snapshot: Snapshot) -> Snapshot:
    """Everything in focus, also where the camera moves."""
    motion = snapshot.motion
    if motion is not None:
        cameras = tuple(replace(camera, aperture_radius=0.0) for camera in motion.cameras)
        motion = replace(motion, cameras=cameras)
    return replace(snapshot, camera=replace(snapshot.camera, aperture_radius=0.0), motion=motion)


def frozen(snapshot: Snapshot) -> Snapshot:
    """Everything where it is at the frame's own time."""
    return replace(snapshot, motion=None)


def dark_world(snapshot: Snapshot) -> Snapshot:
    """No light from outside."""
    return replace(snapshot, world=None)


# ------------------------------------------------------------------ materials


def each_material(snapshot: Snapshot, change: Callable[[Graph], Graph]) -> Snapshot:
    """All materials, changed; one that is shared stays shared."""
    return replace(snapshot, materials=tuple(change(graph) for graph in snapshot.materials))


def each_node(graph: Graph, change: Callable[[Node], Node]) -> Graph:
    """All nodes of a graph, changed."""
    return replace(graph, nodes=tuple(change(node) for node in graph.nodes))


def changed(node: Node, values: Mapping[str, Any]) -> Node:
    """The node with other values at those of its sockets."""
    return replace(node, inputs={name: values.get(name, value) for name, value in node.inputs.items()})


def matte(node: Node) -> Node:
    """Lambert in place of glossy reflection, of the same colour."""
    if node.kind in GLOSSY:
        colour = node.inputs.get("Color", node.inputs.get("Base Color", (0.8, 0.8, 0.8, 1.0)))
        inputs = {"Color": colour, "Roughness": 0.0}
        if "Normal" in node.inputs:
            inputs["Normal"] = node.inputs["Normal"]
        return Node("BsdfDiffuse", node.name, inputs)
    if node.kind == "BsdfPrincipled":
        return changed(node, MATTE)
    return node


def clear_of_refraction(node: Node) -> Node:
    """Lambert in place of glass."""
    if node.kind in REFRACTIVE:
        colour = node.inputs.get("Color", (0.8, 0.8, 0.8, 1.0))
        return Node("BsdfDiffuse", node.name, {"Color": colour, "Roughness": 0.0})
    if node.kind == "BsdfPrincipled":
        return changed(node, {"Transmission Weight": 0.0})
    return node


def flat(node: Node) -> Node:
    """No bump and no normal map."""
    if node.kind in ("Bump", "NormalMap"):
        return changed(node, {"Strength": 0.0})
    return node


def undisplaced(graph: Graph) -> Graph:
    """Nothing moves vertices or normals."""
    outputs = {name: link for name, link in graph.outputs.items() if name != "Displacement"}
    return each_node(replace(graph, outputs=outputs), flat)


def without_volume(graph: Graph) -> Graph:
    """Empty inside."""
    return replace(graph, outputs={n: link for n, link in graph.outputs.items() if n != "Volume"})


def opaque(graph: Graph) -> Graph:
    """Where a Mix Shader has Transparent on one side, the other side; alpha 1; else black."""
    see_through = {k for k, node in enumerate(graph.nodes) if node.kind == "BsdfTransparent"}

    def change(node: Node) -> Node:
        if node.kind == "BsdfPrincipled":
            return changed(node, {"Alpha": 1.0})
        if node.kind == "BsdfTransparent":
            return changed(node, {"Color": (0.0, 0.0, 0.0, 1.0)})
        if node.kind == "MixShader":
            clear = [is_link_to(node.inputs.get(socket), see_through) for socket in ("Shader", "Shader_001")]
            if clear[0] != clear[1]:
                return changed(node, {"Fac": 1.0 if clear[0] else 0.0})
        return node

    return each_node(graph, change)


def is_link_to(value: Any, nodes: set[int]) -> bool:
    """Whether an input is fed by one of some nodes."""
    return isinstance(value, Link) and value.node in nodes


# ------------------------------------------------------------------ who has what


def used_graphs(snapshot: Snapshot) -> Iterator[Graph]:
    """The materials that some object wears."""
    for number in np.unique(snapshot.instances.materials):
        yield snapshot.materials[int(number)]


def no_change(change: Callable[[Graph], Graph], why: str) -> Callable[..., str]:
    """The effect is missing where taking it out changes no material in use."""

    def missing(snapshot: Snapshot, scene: Scene, settings: RenderSettings) -> str:
        return "" if any(graph != change(graph) for graph in used_graphs(snapshot)) else why

    return missing


def feature_off(*names: str) -> Callable[..., str]:
    """The effect is missing where the scene's features say so."""

    def missing(snapshot: Snapshot, scene: Scene, settings: RenderSettings) -> str:
        off = [scene.features[name] for name in names if scene.features.get(name, ON) != ON]
        return off[0].removeprefix("off: ") if len(off) == len(names) else ""

    return missing


def no_volumes(snapshot: Snapshot, scene: Scene, settings: RenderSettings) -> str:
    """The engine clears them of what is in them, so that they cost nothing wherever they are."""
    return no_change(without_volume, NO_MATERIAL)(snapshot, scene, settings) or "volumes are not rendered yet"


def of_snapshot(
    change: Callable[[Snapshot], Snapshot],
) -> Callable[[Snapshot, RenderSettings], tuple[Snapshot, RenderSettings]]:
    """An effect of the scene alone."""
    return lambda snapshot, settings: (change(snapshot), settings)


def of_materials(
    change: Callable[[Graph], Graph],
) -> Callable[[Snapshot, RenderSettings], tuple[Snapshot, RenderSettings]]:
    """An effect of materials alone."""
    return of_snapshot(lambda snapshot: each_material(snapshot, change))


def nodes(change: Callable[[Node], Node]) -> Callable[[Graph], Graph]:
    """A change of single nodes, as one of graphs."""
    return lambda graph: each_node(graph, change)


def shorter(depth: int) -> Effect:
    """Paths without the edges after `depth`, which is bounce number `depth` and all later ones."""

    def missing(snapshot: Snapshot, scene: Scene, settings: RenderSettings) -> str:
        if settings.integrator.startswith("direct"):
            return "the integrator follows one bounce"
        return "" if settings.max_depth > depth else f"paths have {settings.max_depth} edges at most"

    name = f"bounces from the {ORDINALS[depth]} on"
    return Effect(name, missing, lambda snapshot, settings: (snapshot, replace(settings, max_depth=depth)))


ORDINALS = {2: "2nd", 3: "3rd", 4: "4th", 6: "6th", 10: "10th"}
NO_MATERIAL = "no material in use has any"
EFFECTS = (
    Effect(
        "soft shadows",
        lambda snapshot, scene, settings: "" if any(map(has_size, snapshot.lights)) else "no lamp has a size",
        of_snapshot(hard_shadows),
    ),
    Effect("depth of field", feature_off("depth of field"), of_snapshot(pinhole)),
    Effect("motion blur", feature_off("motion blur"), of_snapshot(frozen)),
    Effect("world light", feature_off("environment"), of_snapshot(dark_world)),
    Effect("glossy bounces", no_change(nodes(matte), NO_MATERIAL), of_materials(nodes(matte))),
    Effect(
        "refraction",
        no_change(nodes(clear_of_refraction), NO_MATERIAL),
        of_materials(nodes(clear_of_refraction)),
    ),
    Effect("transparency", feature_off("transparent surfaces"), of_materials(opaque)),
    Effect("bump and displacement", no_change(undisplaced, NO_MATERIAL), of_materials(undisplaced)),
    Effect("volumes", no_volumes, of_materials(without_volume)),
    *(shorter(depth) for depth in ORDINALS),
)
