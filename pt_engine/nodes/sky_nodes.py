"""Sky Texture: the sky of a day, by scattering in the atmosphere or in closed form."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..textures.daylight import daylight
from ..textures.hosek import hosek
from ..textures.sky import MODELS, Settings, Sky, sky
from ..textures.sky_multiple import Air
from .coordinates import coordinates, generated
from .graph import NodeView
from .ir import COLOR, Value, op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


class Radiance(Protocol):
    """Something seen in directions."""

    def radiance(self, d: Float32) -> Float32: ...


class SunDisc(NamedTuple):
    """A sun that some sky texture draws where `direction`, a value of the program, comes near it."""

    direction: Value
    sky: Sky


@op(COLOR)
def seen(what: Radiance, direction: Float32) -> Float32:
    """The radiance of a sky."""
    return what.radiance(direction)


@node("TexSky")
def tex_sky(n: NodeView) -> Outputs:
    kind = str(n.prop("sky_type", "MULTIPLE_SCATTERING"))
    direction = coordinates(n, generated)
    if kind == "NISHITA":  # Blender 4.5's name
        n.approximate("tabulated as Blender 5 does")
        kind = "SINGLE_SCATTERING"
    if kind not in MODELS:
        return {"Color": n.call(seen, direction, static=(legacy(n, kind),))}
    made = sky(settings(n, kind))
    if made.half_angle:
        n.reader.suns.append(SunDisc(direction, made))
    return {"Color": n.call(seen, direction, static=(made,))}


def settings(n: NodeView, model: str) -> Settings:
    """Of the node; without a sun where the reader leaves suns out."""
    aerosols = n.prop("aerosol_density", n.prop("dust_density", 1.0))  # Blender 4.5's name
    shown = n.reader.draw_suns and bool(n.prop("sun_disc", True))
    return Settings(
        model,
        float(n.prop("sun_elevation", np.radians(15.0))),
        float(n.prop("sun_rotation", 0.0)),
        max(float(n.prop("sun_size", 0.009512)), 1e-9) if shown else 0.0,
        float(n.prop("sun_intensity", 1.0)) if shown else 1.0,
        float(n.prop("altitude", 100.0)),
        Air(float(n.prop("air_density", 1.0)), float(aerosols), float(n.prop("ozone_density", 1.0))),
    )


def legacy(n: NodeView, kind: str) -> Radiance:
    """The models in closed form."""
    sun = np.array(n.prop("sun_direction", (0.0, 0.0, 1.0)), np.float32)
    size = np.sqrt((sun * sun).sum())
    sun = sun / size if size > 0 else np.array([0, 0, 1], np.float32)
    toward, turbidity = tuple(float(x) for x in sun), float(n.prop("turbidity", 2.2))
    if kind == "HOSEK_WILKIE":
        return hosek(toward, turbidity, float(n.prop("ground_albedo", 0.3)))
    if kind != "PREETHAM":
        n.approximate(f"the model {kind} is not known: rendered as PREETHAM")
    return daylight(toward, turbidity)
