"""Reading pictures back."""

import OpenImageIO as oiio


def pixels(path):
    """An image file's pixels, bottom row first."""
    buffer = oiio.ImageBuf(str(path))
    assert not buffer.has_error, buffer.geterror()
    return buffer.get_pixels(oiio.FLOAT)[::-1]


def parts(path):
    """Names of all channels of all parts of a multi-layer EXR, and each part's pixels by first channel."""
    found = {}
    source = oiio.ImageInput.open(str(path))
    number = 0
    while source.seek_subimage(number, 0):
        spec = source.spec()
        found[tuple(spec.channelnames)] = source.read_image(number, 0, 0, spec.nchannels, oiio.FLOAT)[::-1]
        number += 1
    source.close()
    return found
