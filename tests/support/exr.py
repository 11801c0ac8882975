"""Reading pictures back."""

import numpy as np
import OpenImageIO as oiio


def pixels(path):
    """An image file's pixels, bottom row first."""
    buffer = oiio.ImageBuf(str(path))
    assert not buffer.has_error, buffer.geterror()
    return buffer.get_pixels(oiio.FLOAT)[::-1]


def channels_of(path):
    """The channels of a multi-layer EXR by name: (rows, columns), bottom row first.

    Blender 5 writes a part for each pass, Blender 4 all channels into one.
    """
    channels = {}
    source = oiio.ImageInput.open(str(path))
    number = 0
    while source.seek_subimage(number, 0):
        spec = source.spec()
        values = source.read_image(number, 0, 0, spec.nchannels, oiio.FLOAT)[::-1]
        values = values.reshape(*values.shape[:2], -1)
        channels.update(zip(spec.channelnames, np.moveaxis(values, -1, 0), strict=True))
        number += 1
    source.close()
    return channels


def passes(path):
    """The passes of three channels or four of a multi-layer EXR of one view layer, alpha left out."""
    found = {name.split(".", 1)[1]: values for name, values in channels_of(path).items()}
    names = dict.fromkeys(name[:-2] for name in found if name.endswith(".B"))
    return {n: np.stack([found[f"{n}.{c}"] for c in "RGB"], axis=-1) for n in names}


def layers(path):
    """The Combined pass of each view layer of a multi-layer EXR: (rows, columns, 4), bottom row first."""
    channels = channels_of(path)
    names = dict.fromkeys(name.split(".")[0] for name in channels if ".Combined." in name)
    return {n: np.stack([channels[f"{n}.Combined.{c}"] for c in "RGBA"], axis=-1) for n in names}
