"""HSV and HSL, both ways, with the branches of Blender's own formulas as selections."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from .math_nodes import divide, select

Float32 = NDArray[np.float32]
SPACES: Final = ("RGB", "HSV", "HSL")


def _hue(rgb: Float32, high: Float32, span: Float32) -> Float32:
    """Hue in [0, 1) of colours with largest component `high` and spread `span`."""
    r, g, b = rgb
    sixth = select(
        r == high, divide(g - b, span), select(g == high, 2 + divide(b - r, span), 4 + divide(r - g, span))
    )
    h = sixth * np.float32(1 / 6)
    return select(h < 0, h + 1, h)


def rgb_to_hsv(rgb: Float32) -> Float32:
    """(3, n) hue, saturation, value."""
    high, low = rgb.max(axis=0), rgb.min(axis=0)
    span = high - low
    s = select(high != 0, divide(span, high), np.float32(0))
    h = select(s != 0, _hue(rgb, high, span), np.float32(0))
    return np.stack([h, s, high])


def hsv_to_rgb(hsv: Float32) -> Float32:
    """(3, n) back to RGB."""
    h, s, v = hsv
    h = select(h == 1, np.float32(0), h) * 6
    h = select((h < 0) | (h >= 6), 5 + h - np.floor(h), h)  # Blender's last branch takes all the rest
    pure = _wheel(h)
    return np.asarray(((pure - 1) * s + 1) * v, np.float32)


def _wheel(h: Float32) -> Float32:
    """Fully saturated colour of hue h in [0, 6)."""
    r = np.abs(h - 3) - 1
    g = 2 - np.abs(h - 2)
    b = 2 - np.abs(h - 4)
    out: Float32 = np.clip(np.stack([r, g, b]), 0, 1)
    return out


def rgb_to_hsl(rgb: Float32) -> Float32:
    """(3, n) hue, saturation, lightness."""
    high, low = rgb.max(axis=0), rgb.min(axis=0)
    span = high - low
    total = high + low
    light = np.minimum(total * np.float32(0.5), 1)
    s = select(light > 0.5, divide(span, 2 - total), divide(span, total))
    s = select(span == 0, np.float32(0), s)
    h = select(span == 0, np.float32(0), _hue(rgb, high, span))
    return np.stack([h, s, light])


def hsl_to_rgb(hsl: Float32) -> Float32:
    """(3, n) back to RGB."""
    h, s, light = hsl
    chroma = (1 - np.abs(2 * light - 1)) * s
    return np.asarray((_wheel(h * 6) - np.float32(0.5)) * chroma + light, np.float32)


def from_rgb(space: str, rgb: Float32) -> Float32:
    """RGB in another model."""
    return {"HSV": rgb_to_hsv, "HSL": rgb_to_hsl}[space](rgb) if space != "RGB" else rgb


def to_rgb(space: str, c: Float32) -> Float32:
    """Another model's colour in RGB."""
    return {"HSV": hsv_to_rgb, "HSL": hsl_to_rgb}[space](c) if space != "RGB" else c
