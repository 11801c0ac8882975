"""The node materials of a public library on a shader ball: exported, compiled, rendered, compared.

`PT_MATERIALS` names the folder of .blend files; without it ../shared/materials beside the project is
tried. They are not part of the project.
"""

from __future__ import annotations

import math
import os
import tempfile
import traceback
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene, mesh
from support.cycles import by_cycles, by_engine
from support.shared_scenes import PROJECT
from support.ztest import compare

from pt_engine.blender.export.scene import export_scene
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import EXACT

LIMIT = 0.05  # beyond noise, of what is exact in every node


@dataclass
class Outcome:
    """What came of a material.

    Attributes
    ----------
    states : counts of its nodes by state
    causes : (kind of node, state, effect) of those that are not exact
    finite : whether both pictures are
    error, noise : beyond noise, and noise, against Cycles; None where not compared
    failure : the exception, "" where there was none
    """

    file: str
    name: str
    states: dict[str, int] = field(default_factory=dict)
    causes: list[tuple[str, str, str]] = field(default_factory=list)
    finite: bool = True
    error: float | None = None
    noise: float | None = None
    p: float | None = None
    means: tuple[float, float] | None = None
    failure: str = ""

    @property
    def is_exact(self) -> bool:
        """Whether every node is."""
        return set(self.states) <= {EXACT}

    @property
    def differs(self) -> bool:
        """Whether it is further from Cycles than it may be."""
        return self.error is not None and self.p is not None and self.error > LIMIT and self.p < 1e-3

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def library() -> Path | None:
    """The folder of materials, None where there is none."""
    root = Path(os.environ.get("PT_MATERIALS") or PROJECT.parent / "shared" / "materials")
    for folder in (root, PROJECT.parents[1] / "shared" / "materials"):
        if folder.is_dir() and any(folder.glob("*.blend")):
            return folder
    return None


def names(file: Path) -> list[str]:
    """Materials in a file, in its order."""
    with bpy.data.libraries.load(str(file)) as (found, _):
        return list(found.materials)


def shader_ball(file: Path, name: str) -> Any:
    """A ball on a plane under even light, with an appended material; the material."""
    scene = empty_scene()
    with bpy.data.libraries.load(str(file), link=False) as (_, wanted):
        wanted.materials = [name]
    material = wanted.materials[0]
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, location=(0, 0, 1))
    ball = bpy.context.object
    ball.data.shade_smooth()
    ball.data.materials.append(material)
    add(mesh([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)], "Floor"))
    sky = bpy.data.worlds.new("Even")
    tree = with_nodes(sky)
    background, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (0.9, 0.9, 0.9, 1)
    tree.links.new(background.outputs[0], end.inputs["Surface"])
    scene.world = sky
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 1.8), (math.radians(80), 0, 0)
    return material


def tried(file: Path, name: str, size: int = 32, samples: int = 8, beside: bool = True) -> Outcome:
    """Everything about one material; `beside` says whether exact ones are compared with Cycles."""
    out = Outcome(file.stem, name)
    try:
        shader_ball(file, name)
        covered(out, name)
        ours = by_engine(samples, (size, size))
        out.finite = bool(np.isfinite(ours).all())
        if beside and out.is_exact:
            with tempfile.TemporaryDirectory() as folder:
                theirs = by_cycles(2 * samples, (size, size), Path(folder))
            pair = [(a[..., :3], b[..., :3]) for a, b in (ours, theirs)]
            agreement = compare(*pair, grid=(6, 6))
            out.error, out.noise, out.p = agreement.error, agreement.noise, agreement.p
            out.means = (float(np.mean(pair[0])), float(np.mean(pair[1])))
    except Exception:
        out.failure = traceback.format_exc(limit=-3).strip()
    return out


def covered(out: Outcome, name: str) -> None:
    """Fill in what the coverage says of the material's nodes."""
    snapshot = export_scene(bpy.context.evaluated_depsgraph_get())
    (graph,) = [g for g in snapshot.materials if g.name == name]
    kinds = {node.name: node.kind for node in graph.nodes}
    entries = compile_materials([graph], snapshot.images).coverage
    out.states = dict(Counter(e.state for e in entries))
    out.causes = [(kinds.get(e.node, "export"), e.state, e.effect) for e in entries if e.state != EXACT]
