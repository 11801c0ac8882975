"""An image file's channels by name, as renderers write them: one layer, or many in one EXR."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .oiio import openimageio

Float32 = NDArray[np.float32]


def channels_of(path: Path) -> dict[str, Float32]:
    """(height, width) float32 by the channel's name in the file, top row first.

    Raises
    ------
    ValueError
        The file can't be read as an image, or its parts differ in size; the message says which and why.
    """
    oiio = openimageio()
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise ValueError(f"{path} can't be read as an image: {oiio.geterror()}")
    found: dict[str, Float32] = {}
    part = 0
    try:
        while source.seek_subimage(part, 0):
            spec = source.spec()
            values = source.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)
            if values is None:
                raise ValueError(f"{path} is damaged: {source.geterror()}")
            found |= dict(zip(spec.channelnames, np.moveaxis(values, -1, 0), strict=True))
            part += 1
    finally:
        source.close()
    if len({channel.shape for channel in found.values()}) != 1:
        raise ValueError(f"{path} has parts of different sizes")
    return found
