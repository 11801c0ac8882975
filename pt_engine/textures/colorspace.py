"""From an image's colour space to scene-linear Rec.709."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]

DATA: Final = frozenset({"Non-Color", "Raw", "Generic Data", "data", "Utility - Raw"})
LINEAR: Final = frozenset(
    {
        "Linear Rec.709",
        "Linear",
        "Linear BT.709 I-D65",
        "scene_linear",
        "scene_linear_srgb",
        "lin_rec709_scene",
    }
)
SRGB: Final = frozenset({"sRGB", "sRGB - Texture", "srgb_rec709_scene"})


def srgb_to_linear(c: Float32) -> Float32:
    """The sRGB decoding curve; negative input gives 0, as in Cycles."""
    c = np.maximum(c, 0)
    low: Float32 = c * np.float32(1 / 12.92)
    high = ((c + np.float32(0.055)) * np.float32(1 / 1.055)) ** np.float32(2.4)
    return low + (c >= np.float32(0.04045)) * (high - low)


def is_data(name: str) -> bool:
    """Whether a colour space means numbers, not colour."""
    return name in DATA


class Converter:
    """Converts pixels through an OpenColorIO config, asked only for what has no closed form here."""

    def __init__(self, config: str = "") -> None:
        self.config = config
        self._loaded: Any = None

    def to_linear(self, rgba: Float32, name: str) -> Float32:
        """(H, W, 4) pixels of colour space `name` in scene-linear Rec.709; alpha is left alone.

        Raises
        ------
        ValueError
            Where the config does not know the space.
        """
        if is_data(name) or name in LINEAR or not name:
            return rgba
        if name in SRGB:
            out = rgba.copy()
            out[..., :3] = srgb_to_linear(rgba[..., :3])
            return out
        return self._through_ocio(rgba, name)

    def _through_ocio(self, rgba: Float32, name: str) -> Float32:
        from .oiio import openimageio

        oiio = openimageio()
        if self._loaded is None:
            self._loaded = oiio.ColorConfig(self.config) if self.config else oiio.ColorConfig()
        linear = self._linear_name(self._loaded.getColorSpaceNames())
        source = oiio.ImageBuf(np.ascontiguousarray(rgba))
        config = self.config or ""
        done = oiio.ImageBufAlgo.colorconvert(source, name, linear, False, "", "", config)
        if done.has_error:
            raise ValueError(f"colour space {name}: {done.geterror().strip()}")
        out = np.asarray(done.get_pixels(oiio.FLOAT), np.float32).reshape(rgba.shape)
        out[..., 3] = rgba[..., 3]
        return out

    @staticmethod
    def _linear_name(names: list[str]) -> str:
        for known in ("Linear Rec.709", "lin_rec709_scene", "lin_srgb", "Linear Rec.709 (sRGB)"):
            if known in names:
                return known
        return "scene_linear"
