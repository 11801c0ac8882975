"""What the enumeration of node kinds cannot see: sensible ranges, set-ups, settings that do nothing.

Every shader node of this Blender is asked about without being named here; a `Recipe` only makes the
questions better.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

Settings = Mapping[str, Any]
TEXTURES = 1e3  # 1/scale of a thousand: beyond, a lattice cell's number or its fraction has lost its digits


class Recipe(NamedTuple):
    """Hints on one kind of node.

    Attributes
    ----------
    ranges : socket identifier → (low, high) of its ordinary values
    limits : socket identifier → (low, high) of its hostile values, short of where Cycles divides by 0
    options : setting → values, beside or instead of those found
    idle : settings → names of those that do nothing beside the others
    setups : name → function of the node, for what is no plain setting (ramps, curves)
    reach : float
        Magnitude of the hostile values of the other sockets.
    elsewhere : str
        The test that asks about this kind, where a sheet of faces cannot.
    """

    ranges: Mapping[str, tuple[float, float]] = {}
    options: Mapping[str, tuple[Any, ...]] = {}
    idle: Callable[[Settings], set[str]] = lambda _: set()
    setups: Mapping[str, Callable[[Any], None]] = {}
    limits: Mapping[str, tuple[float, float]] = {}
    reach: float = 1e20
    elsewhere: str = ""


# ------------------------------------------------------------------ set-ups


def ramp(mode: str, interpolation: str, hue: str = "NEAR") -> Callable[[Any], None]:
    """Sets a ramp of four colours."""

    def make(node: Any) -> None:
        r = node.color_ramp
        r.color_mode, r.interpolation, r.hue_interpolation = mode, interpolation, hue
        r.elements[0].position, r.elements[1].position = 0.1, 0.9
        r.elements[0].color, r.elements[1].color = (0.9, 0.1, 0.2, 1), (0.2, 0.3, 0.9, 0.5)
        r.elements.new(0.4).color = (0.1, 0.8, 0.3, 0.7)
        r.elements.new(0.6).color = (0.7, 0.6, 0.1, 1)

    return make


def crowded_ramp(node: Any) -> None:
    """Two stops at one place, and one outside the first sample."""
    r = node.color_ramp
    r.elements[0].position, r.elements[1].position = 0.5, 0.5
    r.elements[0].color, r.elements[1].color = (0.9, 0.1, 0.2, 1), (0.2, 0.3, 0.9, 0.5)
    r.elements.new(0.501).color = (0.1, 0.8, 0.3, 0.7)


def lone_ramp(node: Any) -> None:
    """A single stop."""
    r = node.color_ramp
    r.elements.remove(r.elements[1])
    r.elements[0].position, r.elements[0].color = 0.3, (0.9, 0.1, 0.2, 0.4)


def ended_ramp(interpolation: str, *positions: float) -> Callable[[Any], None]:
    """Sets a ramp with stops at these places, as at 0 and 1."""

    def make(node: Any) -> None:
        r = node.color_ramp
        r.interpolation = interpolation
        while len(r.elements) < len(positions):
            r.elements.new(0.5)
        for k, (stop, at) in enumerate(zip(list(r.elements), positions, strict=True)):
            stop.position, stop.color = at, (0.1 + 0.2 * k, 0.9 - 0.2 * k, (0.3, 0.8)[k % 2], 0.5 + 0.1 * k)

    return make


RAMPS: dict[str, Callable[[Any], None]] = {
    f"RGB {i}": ramp("RGB", i) for i in ("LINEAR", "CONSTANT", "EASE", "CARDINAL", "B_SPLINE")
}
RAMPS |= {f"{m} {h}": ramp(m, "LINEAR", h) for m in ("HSV", "HSL") for h in ("NEAR", "FAR", "CW", "CCW")}
RAMPS |= {"HSV EASE": ramp("HSV", "EASE"), "crowded": crowded_ramp, "one stop": lone_ramp}
RAMPS |= {f"{i} to the ends": ended_ramp(i, 0.0, 0.4, 1.0) for i in ("CARDINAL", "B_SPLINE")}
RAMPS |= {f"{i} crowded at the ends": ended_ramp(i, 0.0, 0.0, 1.0, 1.0) for i in ("CARDINAL", "B_SPLINE")}


def bend(extend: str = "EXTRAPOLATED", handles: str = "AUTO") -> Callable[[Any], None]:
    """Sets curves of four points per channel."""

    def make(node: Any) -> None:
        for k, curve in enumerate(node.mapping.curves):
            curve.points.new(0.3, 0.55 - 0.1 * k)
            curve.points.new(0.7, 0.5 + 0.1 * k)
            for point in curve.points:
                point.handle_type = handles
        node.mapping.extend = extend
        node.mapping.update()

    return make


BENDS = {"extrapolated": bend(), "horizontal": bend("HORIZONTAL"), "vector handles": bend(handles="VECTOR")}


def tilt(node: Any) -> None:
    node.outputs[0].default_value = (0.5, -0.3, 0.8)


def shade(node: Any) -> None:
    node.outputs[0].default_value = (0.2, 0.5, 0.7, 1.0)


def number(node: Any) -> None:
    node.outputs[0].default_value = -1.75


def named(node: Any) -> None:
    node.attribute_name = "i0"


# ------------------------------------------------------------------ settings that do nothing


def idle_mix(s: Settings) -> set[str]:
    kind = s["data_type"]
    idle = set() if kind == "RGBA" else {"blend_type", "clamp_result"}
    return idle if kind == "VECTOR" else idle | {"factor_mode"}


def idle_wave(s: Settings) -> set[str]:
    return {"rings_direction" if s["wave_type"] == "BANDS" else "bands_direction"}


def idle_voronoi(s: Settings) -> set[str]:
    idle = set()
    if s["voronoi_dimensions"] == "1D" or s["feature"] in ("DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"):
        idle.add("distance")
    if s["feature"] == "N_SPHERE_RADIUS":
        idle.add("normalize")
    return idle


UNIT = (-0.2, 1.2)
OCTAVES = {"Detail": (0.0, 5.0), "Lacunarity": (0.2, 4.0), "Roughness": (-0.5, 2.0), "Scale": (1e-3, 1e3)}
SIZES = {"Brick Width": (0.01, 1e3), "Row Height": (0.01, 1e3), "Mortar Size": (1e-3, 1e3)}
FRACTAL = {"Detail": (0.0, 4.0), "Roughness": UNIT, "Lacunarity": (0.5, 3.0), "Scale": (0.5, 5.0)}
BRICKS = {
    "Mortar Size": (0.0, 0.2),
    "Mortar Smooth": UNIT,
    "Brick Width": (0.1, 1.0),
    "Row Height": (0.1, 0.8),
}

RECIPES = {
    "Attribute": Recipe(options={"attribute_type": ("GEOMETRY",)}, setups={"a vector": named}),
    "Blackbody": Recipe({"Temperature": (200.0, 14000.0)}),
    "Wavelength": Recipe({"Wavelength": (360.0, 800.0)}),
    "HueSaturation": Recipe(dict.fromkeys(("Hue", "Saturation", "Value", "Fac"), UNIT)),
    "Mix": Recipe({"Factor_Float": UNIT, "Factor_Vector": UNIT}, idle=idle_mix),
    "MixRGB": Recipe({"Fac": UNIT}, {"use_alpha": ()}),
    "ValToRGB": Recipe({"Fac": UNIT}, setups=RAMPS),
    "RGBCurve": Recipe({"Fac": UNIT}, setups=BENDS),
    "VectorCurve": Recipe({"Fac": UNIT}, setups=BENDS),
    "FloatCurve": Recipe({"Factor": UNIT}, setups=BENDS),
    "Normal": Recipe(setups={"tilted": tilt}),
    "Value": Recipe(setups={"-1.75": number}),
    "RGB": Recipe(setups={"a blue": shade}),
    "TexMagic": Recipe(
        {"Scale": (0.5, 5.0)},
        {"turbulence_depth": tuple(range(11))},
        limits={"Distortion": (-3.0, 3.0)},
        reach=TEXTURES,
    ),
    "TexBrick": Recipe(
        BRICKS,
        {
            "offset": (0.5, 0.3),
            "offset_frequency": (2, 3),
            "squash": (1.0, 0.6, 0.0),
            "squash_frequency": (2, 3),
        },
        limits=SIZES,
        reach=TEXTURES,
    ),
    "TexNoise": Recipe(FRACTAL | {"Distortion": (-0.5, 1.0)}, limits=OCTAVES, reach=TEXTURES),
    "TexVoronoi": Recipe(
        FRACTAL | {"Randomness": UNIT, "Smoothness": UNIT, "Exponent": (0.3, 4.0)},
        idle=idle_voronoi,
        limits=OCTAVES | {"Exponent": (0.1, 32.0)},
        reach=TEXTURES,
    ),
    "TexWave": Recipe(
        FRACTAL | {"Detail Roughness": UNIT},
        idle=idle_wave,
        limits=OCTAVES | {"Detail Roughness": (-0.5, 2.0)},
        reach=TEXTURES,
    ),
    "TexGabor": Recipe(
        {"Anisotropy": UNIT, "Frequency": (0.5, 4.0), "Orientation 3D": (0.1, 2.0)},
        limits={"Scale": (1e-3, 1e3), "Orientation 3D": (1e-3, 1e3)},  # along z Cycles divides 0 by 0
        reach=TEXTURES,
    ),
    "TexImage": Recipe(elsewhere="tests/textures"),
    "TexEnvironment": Recipe(elsewhere="tests/textures"),
    "RadialTiling": Recipe({"Sides": (2.0, 9.0), "Roundness": UNIT}),
}
