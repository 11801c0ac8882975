"""Texels as Cycles keeps them: in the file's own number format, with alpha associated.

A file holds bytes, 16-bit integers, half or full floats; one channel stays one, all else becomes RGBA. An
image of a colour space that must be converted becomes half floats first (unless it is of full ones), so
values above 1 survive; the rounding of each step is Cycles' too.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from . import colorspace

Array = NDArray[Any]
Float32 = NDArray[np.float32]

LARGEST_HALF: Final = np.float32(65504)
WHOLE: Final = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}  # what stands for 1


def conform(
    raw: Array,
    alpha_mode: str,
    kind: str,
    name: str = "",
    converter: colorspace.Converter | None = None,
    as_rgba: bool = False,
) -> Array:
    """Pixels of a file as texels.

    Parameters
    ----------
    raw : (H, W, C) uint8, uint16, float16 or float32
        One channel is grey, two are grey and alpha, more than four are cut to RGBA.
    alpha_mode : str
        STRAIGHT, PREMUL, CHANNEL_PACKED or NONE.
    kind, name, converter
        The colour space's kind, and for NAMED ones its name and who converts it.
    as_rgba : bool
        Grey becomes RGBA before anything else.

    Returns
    -------
    (H, W, 1) or (H, W, 4), C-contiguous, of the same type (NAMED integers: float16)
    """
    if as_rgba:
        raw = to_rgba(raw)
    channels = raw.shape[2]
    if kind == colorspace.NAMED and raw.dtype in WHOLE:
        raw = to_half(to_float(raw))
    if channels == 4 and alpha_mode == "STRAIGHT" and kind != colorspace.DATA:
        raw = associated(raw)
    texels = raw if channels == 1 else to_rgba(raw)
    if alpha_mode == "NONE" and channels > 1:
        texels = with_alpha(texels, one(texels.dtype))
    if kind == colorspace.NAMED and converter is not None:
        straight = alpha_mode in ("NONE", "CHANNEL_PACKED")
        texels = converted(texels, straight, name, converter)
    return np.ascontiguousarray(finite(texels))


def one(dtype: np.dtype[Any]) -> int | float:
    """What stands for 1 in a number format."""
    return WHOLE.get(dtype, 1.0)


def to_float(values: Array) -> Float32:
    """Values in [0, 1] of integers; floats as they are."""
    scale = np.float32(1 / one(values.dtype))
    return values.astype(np.float32) * scale if values.dtype in WHOLE else values.astype(np.float32)


def to_half(values: Float32) -> NDArray[np.float16]:
    """The nearest half floats, none of them infinite."""
    return np.clip(values, -LARGEST_HALF, LARGEST_HALF).astype(np.float16)


def associated(rgba: Array) -> Array:
    """Colour times alpha, rounded as the number format wants it."""
    alpha = rgba[..., 3:]
    if (alpha == one(rgba.dtype)).all():
        return rgba
    out = rgba.copy()
    if rgba.dtype in WHOLE:
        product = rgba[..., :3].astype(np.uint32) * alpha
        product //= np.uint32(WHOLE[rgba.dtype])
        out[..., :3] = product
    elif rgba.dtype == np.float16:
        out[..., :3] = to_half(rgba[..., :3].astype(np.float32) * alpha.astype(np.float32))
    else:
        out[..., :3] *= alpha
    return out


def to_rgba(data: Array) -> Array:
    """(H, W, C) of grey with alpha, RGB, RGBA or more channels as RGBA."""
    height, width, channels = data.shape
    if channels >= 4:
        return data[..., :4]
    out = np.empty((height, width, 4), data.dtype)
    out[..., :3] = data[..., :1] if channels < 3 else data
    out[..., 3] = data[..., 1] if channels == 2 else one(data.dtype)
    return out


def with_alpha(rgba: Array, alpha: float) -> Array:
    """The same colour with a constant alpha."""
    out = rgba.copy()
    out[..., 3] = alpha
    return out


def converted(texels: Array, straight: bool, name: str, converter: colorspace.Converter) -> Array:
    """Scene-linear texels. Unless they are `straight`, colour is divided by alpha for the conversion.

    OpenColorIO's fast power passes alpha through as alpha¹, not quite the same number; what it gives is kept.
    """
    values = texels.astype(np.float32)
    if texels.shape[2] == 1:
        grey = np.concatenate([values, values, values, np.ones_like(values)], axis=2)
        out = converter.convert(grey, name)[..., :3].mean(axis=2, keepdims=True, dtype=np.float32)
    else:
        if not straight:
            values[..., :3] *= 1 / divisible(values[..., 3:])
        out = converter.convert(values, name)
        if not straight:
            out[..., :3] *= divisible(out[..., 3:])
    return to_half(out) if texels.dtype == np.float16 else out


def divisible(alpha: Float32) -> Float32:
    """Alpha, or 1 where nothing can be divided by it."""
    return np.where(alpha <= 0, np.float32(1), alpha)


def finite(texels: Array) -> Array:
    """Black, transparent texels where any channel is not a number, or infinite."""
    if texels.dtype in WHOLE:
        return texels
    bad = ~np.isfinite(texels).all(axis=2)
    if not bad.any():
        return texels
    out = texels.copy()
    out[bad] = 0
    return out
