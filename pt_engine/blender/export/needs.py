"""Which mesh layers the materials' graphs look at, so that the others stay in Blender."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ...scene.snapshot import Graph, Link, Node

PARTICLE_ROWS = ("particle", "particle location", "particle velocity", "particle angular velocity")
GENERATED_BY_DEFAULT = {
    "TexNoise",
    "TexVoronoi",
    "TexWave",
    "TexMagic",
    "TexChecker",
    "TexBrick",
    "TexGradient",
    "TexGabor",
}


@dataclass(frozen=True)
class Needs:
    """What graphs look at.

    Attributes
    ----------
    uvs, colors : frozenset of str
        Names of UV maps and other attributes ("" the active one).
    generated : bool
    displaced : bool
        Whether vertices are moved.
    objects : frozenset of str
        Rows of `Instances.attributes`.
    strand_normals : bool
        Whether hair is flat.
    """

    uvs: frozenset[str] = frozenset()
    colors: frozenset[str] = frozenset()
    generated: bool = False
    displaced: bool = False
    objects: frozenset[str] = frozenset()
    strand_normals: bool = False

    def __or__(self, other: Needs) -> Needs:
        return Needs(
            self.uvs | other.uvs,
            self.colors | other.colors,
            self.generated or other.generated,
            self.displaced or other.displaced,
            self.objects | other.objects,
            self.strand_normals or other.strand_normals,
        )


def graph_needs(graph: Graph) -> Needs:
    """What one graph looks at."""
    used = {link for node in graph.nodes for link in node.inputs.values() if isinstance(link, Link)}
    outputs: dict[int, set[str]] = {}
    for link in used:
        outputs.setdefault(link.node, set()).add(link.socket)
    moves = graph.displacement_method != "BUMP" and "Displacement" in graph.outputs
    return union(
        [Needs(displaced=moves)]
        + [node_needs(node, outputs.get(number, set())) for number, node in enumerate(graph.nodes)]
    )


def node_needs(node: Node, outputs: set[str]) -> Needs:
    """What one node looks at, of whose outputs `outputs` are used."""
    props = node.props
    if node.kind in ("TexCoord", "UVMap") and props.get("from_instancer"):
        return Needs(objects=frozenset(f"instancer {name.lower()}" for name in outputs & {"UV", "Generated"}))
    if node.kind == "TexCoord":
        return Needs(uvs=uv_if("UV" in outputs), generated="Generated" in outputs)
    if node.kind == "NewGeometry":
        own = {name.lower().replace(" ", "_") for name in outputs & {"Pointiness", "Random Per Island"}}
        return Needs(colors=frozenset(own), generated="Tangent" in outputs)
    if node.kind == "ParticleInfo":
        return Needs(objects=frozenset(PARTICLE_ROWS))
    if node.kind == "UVMap":
        return Needs(uvs=frozenset({str(props["uv_map"])}))
    if node.kind == "NormalMap" and props["space"] == "TANGENT":
        return Needs(uvs=frozenset({str(props["uv_map"])}))
    if node.kind == "Tangent":
        uv = props["direction_type"] == "UV_MAP"
        return Needs(uvs=uv_if(uv, props["uv_map"]), generated=not uv)
    if node.kind == "VertexColor":
        return Needs(colors=frozenset({str(props["layer_name"])}))
    if node.kind == "Attribute":
        return attribute_needs(str(props["attribute_type"]), str(props["attribute_name"]))
    if node.kind == "Raycast":
        numbers = (name.removeprefix("Attribute_") for name in outputs if name.startswith("Attribute_"))
        return union(attribute_needs("GEOMETRY", str(node.inputs[f"Value_{k}"])) for k in numbers)
    if node.kind == "TexImage":
        return Needs(uvs=uv_if(node.inputs.get("Vector") is None))
    if node.kind == "BsdfHairPrincipled":
        return Needs(strand_normals=props["model"] == "HUANG" and node.inputs.get("Aspect Ratio") != 1)
    if node.kind in GENERATED_BY_DEFAULT:
        return Needs(generated=node.inputs.get("Vector") is None)
    if node.kind == "VectorDisplacement":
        return Needs(uvs=uv_if(props["space"] == "TANGENT"))
    if any(socket.endswith("Tangent") for socket in node.inputs):
        return Needs(generated=True)  # Cycles' default tangent goes around Generated's Z
    return Needs()


def attribute_needs(kind: str, name: str) -> Needs:
    """What an Attribute node looks at; some names are Cycles' own."""
    if kind != "GEOMETRY":
        return Needs(objects=frozenset({f"{kind.lower()}:{name}"}) if kind != "VIEW_LAYER" else frozenset())
    if name == "generated":
        return Needs(generated=True)
    if name.rpartition(".")[2] in ("tangent", "tangent_sign"):
        return Needs(uvs=frozenset({name.rpartition(".")[0]}))
    names = frozenset({"" if name in ("uv", "vertex_color") else name})
    return Needs() if name == "" else Needs(uvs=names, colors=names)


def uv_if(condition: bool, name: object = "") -> frozenset[str]:
    """The UV map `name`, where the condition holds."""
    return frozenset({str(name)}) if condition else frozenset()


def union(needs: Iterable[Needs]) -> Needs:
    """All of them together."""
    total = Needs()
    for one in needs:
        total = total | one
    return total
