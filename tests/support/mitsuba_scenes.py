"""Mitsuba's scenes as snapshots: the same nested dicts go to `mitsuba.load_dict` and to our engine.

A Mitsuba camera looks along +Z with +X to the left of the image; area emitters shine on one side, which
a Backfacing node says here. Spheres are tessellated finely; `diffuse` without `twosided` is taken as
two-sided, so its back must not be seen (emitters excepted: their back is black).
"""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
from support.scenes import diffuse, mesh, quad, rgba, scene, shader, sphere, translation, world

from pt_engine.scene.snapshot import CameraData, Graph, LightData, Link, MeshData, Node, Snapshot

Plugin = dict[str, Any]
RINGS = 128  # of a tessellated sphere: its silhouette is 1.5e-4 of the radius too small
LIGHT_RINGS = 48
FLIP_X_Z = np.diag([-1.0, 1.0, -1.0, 1.0])


def load_json(path: Path | str) -> Plugin:
    """A scene dict; transforms stay {"matrix": rows}."""
    with open(path, encoding="utf-8") as file:
        content: Plugin = json.load(file)
    return content


def load_xml(path: Path | str) -> Plugin:
    """A scene dict from Mitsuba 3's XML, as far as the reference scenes use it."""
    root = ElementTree.parse(path).getroot()
    defaults = {f"${e.get('name')}": e.get("value", "") for e in root.findall("default")}
    return _plugin(root, defaults, "scene")


def _plugin(element: ElementTree.Element, defaults: dict[str, str], kind: str) -> Plugin:
    result: Plugin = {"type": kind}
    for number, child in enumerate(element):
        name, value = child.get("name", ""), child.get("value", "")
        value = defaults.get(value, value)
        if child.tag in ("float", "integer"):
            result[name] = float(value) if child.tag == "float" else int(value)
        elif child.tag == "string":
            result[name] = value
        elif child.tag == "rgb":
            result[name] = {"type": "rgb", "value": [float(x) for x in value.replace(",", " ").split()]}
        elif child.tag == "transform":
            result[name] = {"matrix": _transform(child).tolist()}
        elif child.tag == "ref":
            result["bsdf"] = {"type": "ref", "id": child.get("id")}
        elif child.tag != "default":
            key = child.get("id") or child.tag + (str(number) if child.tag in ("shape", "bsdf") else "")
            result[key] = _plugin(child, defaults, child.get("type", ""))
    return result


def _transform(element: ElementTree.Element) -> np.ndarray:
    total = np.eye(4)
    for step in element:
        values = [float(x) for x in step.get("value", "").replace(",", " ").split()]
        if step.tag == "matrix":
            total = np.array(values).reshape(4, 4) @ total
        elif step.tag == "translate":
            total = translation(*values) @ total
        else:
            raise ValueError(f"<{step.tag}> in a transform is not understood")
    return total


def snapshot_of(content: Plugin) -> Snapshot:
    """The dict of a scene becomes a snapshot."""
    objects, lights, sky = [], [], None
    for child in content.values():
        kind = child.get("type", "") if isinstance(child, dict) else ""
        if kind in ("rectangle", "cube", "sphere"):
            objects.append((_shape(child), _placement(child), _material(child, content)))
        elif kind == "constant":
            sky = world(_color(child["radiance"]))
        elif kind == "point":
            lights.append(_point(child))
    sensor = content["sensor"]
    return scene(objects, _camera(sensor, *resolution(content)), lights, sky)


def resolution(content: Plugin) -> tuple[int, int]:
    """Width and height of the film."""
    film = content["sensor"]["film"]
    return int(film["width"]), int(film["height"])


def _camera(sensor: Plugin, width: int, height: int) -> CameraData:
    across = {"x": width, "y": height, "smaller": min(width, height), "larger": max(width, height)}
    pixel = 2 * math.tan(math.radians(sensor["fov"]) / 2) / across[sensor.get("fov_axis", "x")]
    x, y = pixel * width / 2, pixel * height / 2
    return CameraData("PERSP", _matrix(sensor) @ FLIP_X_Z, (-x, x, -y, y), clip=(1e-4, 1e5))


def _matrix(plugin: Plugin) -> np.ndarray:
    given = plugin.get("to_world")
    return np.eye(4) if given is None else np.array(given["matrix"], np.float64)


def _shape(shape: Plugin) -> MeshData:
    if shape["type"] == "rectangle":
        return quad(2.0)
    if shape["type"] == "cube":
        return _cube()
    lit = "emitter" in shape
    return sphere(1.0, LIGHT_RINGS if lit else RINGS, smooth=not lit)


def _cube() -> MeshData:
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh(corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], name="cube")


def _placement(shape: Plugin) -> np.ndarray:
    if shape["type"] != "sphere":
        return _matrix(shape)
    size = np.diag([shape.get("radius", 1.0)] * 3 + [1.0])
    return _matrix(shape) @ translation(*shape.get("center", (0, 0, 0))) @ size


def _point(light: Plugin) -> LightData:
    """Mitsuba's intensity is I W/sr per channel; Blender's power 4πI W."""
    intensity = _color(light["intensity"])
    return LightData("POINT", "point", translation(*light["position"]), 4 * math.pi, intensity)


def _color(value: Plugin | float) -> tuple[float, float, float]:
    if isinstance(value, int | float):
        return (float(value),) * 3
    given = value["value"]
    r, g, b = (given,) * 3 if isinstance(given, int | float) else given
    return float(r), float(g), float(b)


def _material(shape: Plugin, content: Plugin) -> Graph:
    bsdf = shape.get("bsdf") or next((c for c in shape.values() if _is_bsdf(c)), {"type": "diffuse"})
    if bsdf["type"] == "ref":
        bsdf = content[bsdf["id"]]
    if bsdf["type"] == "twosided":
        bsdf = next(c for c in bsdf.values() if isinstance(c, dict))
    graph = MATERIALS[bsdf["type"]](bsdf)
    return _shining(graph, _color(shape["emitter"]["radiance"])) if "emitter" in shape else graph


def _is_bsdf(child: Any) -> bool:
    return isinstance(child, dict) and child.get("type") in (*MATERIALS, "twosided", "ref")


def _diffuse(bsdf: Plugin) -> Graph:
    return diffuse(_color(bsdf.get("reflectance", 0.5)))


def _conductor(bsdf: Plugin) -> Graph:
    tint = rgba(_color(bsdf.get("specular_reflectance", 1.0)))
    alpha = bsdf.get("alpha", 0.1) if bsdf["type"] == "roughconductor" else 0.0
    return shader(
        "PtConductor",
        "conductor",
        {"distribution": bsdf.get("distribution", "beckmann").upper()},
        Color=tint,
        Eta=_color(bsdf["eta"]),
        K=_color(bsdf["k"]),
        Roughness=math.sqrt(alpha),  # Blender's roughness² is Mitsuba's alpha
    )


def _dielectric(bsdf: Plugin) -> Graph:
    rough = bsdf["type"] == "roughdielectric"
    return shader(
        "BsdfGlass",
        "dielectric",
        {"distribution": bsdf.get("distribution", "beckmann").upper()},
        Color=rgba(1.0),
        Roughness=math.sqrt(bsdf.get("alpha", 0.1)) if rough else 0.0,
        IOR=bsdf["int_ior"] / bsdf.get("ext_ior", 1.0),
    )


def _plastic(bsdf: Plugin) -> Graph:
    return shader(
        "PtRoughPlastic",
        "plastic",
        {"nonlinear": bsdf.get("nonlinear", False)},
        Specular_Color=rgba(_color(bsdf.get("specular_reflectance", 1.0))),
        Color=rgba(_color(bsdf.get("diffuse_reflectance", 0.5))),
        Roughness=math.sqrt(bsdf.get("alpha", 0.1)) if bsdf["type"] == "roughplastic" else 0.0,
        IOR=bsdf["int_ior"] / bsdf.get("ext_ior", 1.0),
    )


MATERIALS = {
    "plastic": _plastic,
    "roughplastic": _plastic,
    "diffuse": _diffuse,
    "conductor": _conductor,
    "roughconductor": _conductor,
    "dielectric": _dielectric,
    "roughdielectric": _dielectric,
}


def _shining(graph: Graph, radiance: tuple[float, float, float]) -> Graph:
    """Emission in front on top of a one-node material, black behind (as a one-sided area emitter)."""
    bsdf = graph.nodes[0]
    nodes = (
        bsdf,
        Node("Emission", "emission", {"Color": rgba(radiance), "Strength": 1.0}),
        Node("AddShader", "front", {"Shader": Link(0, "BSDF"), "Shader_001": Link(1, "Emission")}),
        Node("BsdfDiffuse", "back", {"Color": rgba(0.0), "Roughness": 0.0}),
        Node("NewGeometry", "side", {}),
        Node(
            "MixShader",
            "mix",
            {"Fac": Link(4, "Backfacing"), "Shader": Link(2, "Shader"), "Shader_001": Link(3, "BSDF")},
        ),
    )
    return Graph("one-sided light", nodes, {"Surface": Link(5, "Shader")})


def resized(content: Plugin, width: int, height: int) -> Plugin:
    """The same scene with another film size and a box filter."""
    film = {**content["sensor"]["film"], "width": width, "height": height, "rfilter": {"type": "box"}}
    return {**content, "sensor": {**content["sensor"], "film": film}}


def for_mitsuba(content: Plugin) -> Plugin:
    """The dict with transforms that `mitsuba.load_dict` takes (a variant must be set)."""
    import mitsuba

    result: Plugin = {}
    for key, value in content.items():
        if isinstance(value, dict) and "matrix" in value:
            result[key] = mitsuba.ScalarTransform4f(np.array(value["matrix"]))
        else:
            result[key] = for_mitsuba(value) if isinstance(value, dict) else value
    return result


def rendered_by_mitsuba(content: Plugin, samples: int, seed: int) -> np.ndarray:
    """(height, width, 3) float32, top row first."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    image = mitsuba.render(mitsuba.load_dict(for_mitsuba(content)), spp=samples, seed=seed)
    return np.array(image, np.float32)[..., :3]


__all__ = [
    "load_json",
    "load_xml",
    "rendered_by_mitsuba",
    "resized",
    "resolution",
    "snapshot_of",
]
