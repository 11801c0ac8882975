"""Image files of every kind for tests, written with OpenImageIO."""

import numpy as np
import OpenImageIO as oiio

FORMATS = {"uint8": oiio.UINT8, "uint16": oiio.UINT16, "half": oiio.HALF, "float": oiio.FLOAT}
WHOLE = {"uint8": (255, np.uint8), "uint16": (65535, np.uint16)}


def pattern(height, width, channels, seed=0, high=1.0):
    """(height, width, channels) random values in [0, high]; alpha has zeros, ones and halves in it."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(0, high, (height, width, channels)).astype(np.float32)
    if channels in (2, 4):
        alpha = values[..., -1]
        alpha[:] = rng.choice(np.array([0, 0.25, 0.5, 0.8, 1], np.float32), alpha.shape)
    return values


def write(path, values, form="uint8", **attributes):
    """An image file of float values, top row first; `form` is uint8, uint16, half or float."""
    height, width, channels = values.shape
    spec = oiio.ImageSpec(width, height, channels, form)
    if channels in (2, 4):
        spec.attribute("oiio:UnassociatedAlpha", 1)
        spec.alpha_channel = channels - 1
    for name, value in attributes.items():
        spec.attribute(name.replace("_", ":", 1), value)
    out = oiio.ImageOutput.create(str(path))
    assert out is not None, oiio.geterror()
    assert out.open(str(path), spec), out.geterror()
    scale, dtype = WHOLE.get(form, (1, np.float32))
    stored = np.rint(values * scale).astype(dtype) if form in WHOLE else values
    assert out.write_image(np.ascontiguousarray(stored)), out.geterror()
    out.close()
    return path
