"""From an image's colour space to the scene's linear one.

Cycles sorts the spaces of an OpenColorIO config into four kinds: numbers that are no colour, the scene's
linear space itself, the same with the sRGB curve (texels stay encoded and are decoded after filtering), and
all others, which are converted texel by texel before filtering.
"""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .oiio import keeps, openimageio

Float32 = NDArray[np.float32]

DATA: Final = "data"
LINEAR: Final = "linear"
SRGB: Final = "srgb"
NAMED: Final = "named"

DATA_NAMES: Final = frozenset({"Non-Color", "Raw", "Generic Data", "data", "Utility - Raw"})
LINEAR_NAMES: Final = frozenset(
    {
        "Linear Rec.709",
        "Linear",
        "Linear BT.709 I-D65",
        "scene_linear",
        "lin_rec709_scene",
    }
)
SRGB_NAMES: Final = frozenset({"sRGB", "sRGB - Texture", "srgb_rec709_scene", "scene_linear_srgb"})
REC709_NAMES: Final = ("Linear Rec.709", "lin_rec709_scene", "lin_srgb", "Linear Rec.709 (sRGB)")


class UnknownSpace(ValueError):
    """A colour space that the config does not have, or cannot convert from."""


def srgb_to_linear(c: Float32) -> Float32:
    """The sRGB decoding curve; negative input gives 0, as in Cycles."""
    c = np.maximum(c, 0)
    low: Float32 = c * np.float32(1 / 12.92)
    high = c + np.float32(0.055)
    high *= np.float32(1 / 1.055)
    np.log(high, out=high)  # a logarithm and an exponential take less time than a power
    high *= np.float32(2.4)
    np.exp(high, out=high)
    high -= low
    np.copyto(c, c >= np.float32(0.04045))  # a mask of floats: numpy multiplies by it faster than by booleans
    high *= c
    low += high
    return low


def is_data(name: str) -> bool:
    """Whether a colour space means numbers, not colour."""
    return name in DATA_NAMES


class Converter:
    """Knows the colour spaces of a config, and converts those that have no closed form here.

    Parameters
    ----------
    config : str
        Path of an OpenColorIO config; "" for the one that OpenImageIO brings.
    """

    def __init__(self, config: str = "") -> None:
        self.config = config
        self._kinds: dict[str, str] = {}
        self._linear = ""
        self._is_rec709: bool | None = None

    def kind(self, name: str) -> str:
        """DATA, LINEAR, SRGB or NAMED.

        Raises
        ------
        UnknownSpace
        """
        if not name:
            return LINEAR
        if name not in self._kinds:
            self._kinds[name] = self._kind(name)
        return self._kinds[name]

    def _kind(self, name: str) -> str:
        if is_data(name):
            return DATA
        if name == "scene_linear":
            return LINEAR
        if self.is_rec709:
            if name in LINEAR_NAMES:
                return LINEAR
            if name in SRGB_NAMES:
                return SRGB
        return self._measured(name)

    @property
    def is_rec709(self) -> bool:
        """Whether the scene's linear space is Rec.709, as far as the config's text tells."""
        if self._is_rec709 is None:
            text = Path(self.config).read_text("utf-8", "replace") if Path(self.config).is_file() else ""
            role = re.search(r"^\s+scene_linear:\s*(.+?)\s*$", text, re.MULTILINE)
            self._is_rec709 = role is None or role[1].strip("\"'") in LINEAR_NAMES
        return self._is_rec709

    def _measured(self, name: str) -> str:
        """Kind by Cycles' test: 256 steps of red, green, blue and white through the conversion."""
        v = np.linspace(0, 1, 256, dtype=np.float32)
        ramps = np.zeros((4, 256, 4), np.float32)
        for k in range(3):
            ramps[k, :, k] = ramps[3, :, k] = v
        out = self.convert(ramps, name)[..., :3]
        white = out[3]
        crossed = max(abs(out[k][:, c]).max() for k in range(3) for c in range(3) if c != k)
        alone = np.stack([out[k][:, k] for k in range(3)], axis=1)
        if crossed > 1e-5 or not _equal(alone, white, 1e-6) or not _equal(white[:, :1], white, 1e-6):
            return NAMED
        grey = white.mean(axis=1)
        if _equal(grey, v, 1e-6):
            return LINEAR
        return SRGB if _equal(grey, srgb_to_linear(v), 1e-4) else NAMED

    def convert(self, rgba: Float32, name: str) -> Float32:
        """(H, W, 4) straight pixels of colour space `name` as scene-linear ones.

        Raises
        ------
        UnknownSpace
        """
        oiio = openimageio()
        source = oiio.ImageBuf(np.ascontiguousarray(rgba))
        if self._is_kept:
            done = oiio.ImageBufAlgo.colorconvert(source, name, self.linear_name, False)
        else:
            done = oiio.ImageBufAlgo.colorconvert(source, name, self.linear_name, False, "", "", self.config)
        if done.has_error:
            raise UnknownSpace(f"colour space {name}: {done.geterror().strip()}")
        return np.asarray(done.get_pixels(oiio.FLOAT), np.float32).reshape(rgba.shape)

    @cached_property
    def _is_kept(self) -> bool:
        return bool(self.config) and keeps(self.config)

    @property
    def linear_name(self) -> str:
        """The config's name of what is rendered in."""
        if self.config:
            return "scene_linear"
        if not self._linear:
            names: list[Any] = openimageio().ColorConfig().getColorSpaceNames()
            self._linear = next((known for known in REC709_NAMES if known in names), "scene_linear")
        return self._linear


def _equal(a: Float32, b: Float32, tolerance: float) -> bool:
    """Within a tolerance, or 64 steps of float32 (Cycles' comparison)."""
    return bool((np.abs(a - b) <= np.maximum(tolerance, 64 * np.spacing(np.abs(b)))).all())
