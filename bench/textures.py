"""What a look-up in an image texture costs, in nanoseconds a lane, and how long an image takes to decode.

Thread CPU time, the best of some repeats. `coherent` lanes look at neighbouring texels, as camera rays do;
`random` ones anywhere, as after a diffuse bounce; `tiled` is coherent, with a pool of tiles that they fit in.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from pt_engine.core.memory import kept_buffers
from pt_engine.scene.snapshot import ImageData
from pt_engine.textures.images import TextureStore

LANES = 1 << 16
REPEATS = 7
FILTERS = ("Closest", "Linear", "Cubic")
IMAGES = {  # channels, number format, suffix, colour space
    "grey, 8 bit": (1, "uint8", ".tif", "Non-Color"),
    "sRGB, 8 bit": (3, "uint8", ".tif", "sRGB"),
    "sRGB and alpha, 8 bit": (4, "uint8", ".tif", "sRGB"),
    "RGB, half": (3, "half", ".exr", "Linear Rec.709"),
    "RGB, float": (3, "float", ".exr", "Linear Rec.709"),
}


def textures(size: int = 4096) -> dict[str, dict[str, Any]]:
    """By image: `decode` in seconds, then ns a lane by filter and kind of lanes."""
    return {name: one(size, *image) for name, image in IMAGES.items()}


def one(size: int, channels: int, form: str, suffix: str, space: str) -> dict[str, Any]:
    """The figures of one image."""
    image = ImageData("bench", space, encoded=encoded(size, channels, form, suffix), suffix=suffix)
    started = time.thread_time()
    whole = TextureStore([image])
    whole.texture(0, "Linear", "REPEAT", False)
    found: dict[str, Any] = {"decode": time.thread_time() - started}
    tiled = TextureStore([image], limit=whole.statistics()["bytes"] // 2)
    with kept_buffers():
        for interpolation in FILTERS:
            for kind, store, (u, v) in (
                ("coherent", whole, coherent()),
                ("random", whole, random()),
                ("tiled", tiled, coherent()),
            ):
                texture = store.texture(0, interpolation, "REPEAT", False)
                found[f"{interpolation}, {kind}"] = best(lambda t=texture, u=u, v=v: t.sample(u, v))
    return found


def best(call: Any) -> float:
    """Nanoseconds a lane."""
    seconds = []
    for _ in range(REPEATS):
        started = time.thread_time()
        call()
        seconds.append(time.thread_time() - started)
    return min(seconds) / LANES * 1e9


def coherent() -> tuple[np.ndarray, np.ndarray]:
    """A quarter of the image, in rows."""
    side = int(LANES**0.5)
    k = np.arange(LANES)
    return (k % side / (2 * side)).astype(np.float32), (k // side / (2 * side)).astype(np.float32)


def random() -> tuple[np.ndarray, np.ndarray]:
    """Anywhere."""
    u, v = np.random.default_rng(0).random((2, LANES), dtype=np.float32)
    return u, v


def encoded(size: int, channels: int, form: str, suffix: str) -> np.ndarray:
    """The bytes of a file of random squares."""
    squares = np.random.default_rng(0).random((size // 16, size // 16, channels), dtype=np.float32)
    pixels = squares.repeat(16, axis=0).repeat(16, axis=1)
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, f"bench{suffix}"))
        out = oiio.ImageOutput.create(path)
        out.open(path, oiio.ImageSpec(size, size, channels, form))
        out.write_image(pixels)
        out.close()
        return np.fromfile(path, np.uint8)
