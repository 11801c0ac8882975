"""Two image files compared: MSE, relMSE, FLIP, and a z-test where the files know their noise."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..textures.channels import channels_of
from .errors import Picture, bias, mse, relative_mse
from .optional import MissingPackage, optional
from .tables import plural

Float32 = NDArray[np.float32]
NOISE = "Standard Error"  # the pass that PT Engine writes


def picture_of(path: Path) -> Picture:
    """Colour and, where a pass *Standard Error* tells it, the noise's variance; top row first.

    Raises
    ------
    ValueError
        No image, or one without colours or with numbers that are not finite.
    """
    channels = channels_of(path)
    colour = triple(channels, "Combined") or triple(channels, "")
    if colour is None:
        raise ValueError(f"{path} has no red, green and blue: its channels are {', '.join(channels)}")
    error = triple(channels, NOISE)
    mean = np.stack(colour, axis=-1).astype(np.float64)
    if not np.isfinite(mean).all():
        bad = int((~np.isfinite(mean)).any(axis=2).sum())
        raise ValueError(f"{path} has {plural(bad, 'pixel')} with numbers that are not finite")
    noise = None if error is None else np.stack(error, axis=-1).astype(np.float64) ** 2
    told = noise is not None and bool((np.isfinite(noise) & (noise > 0)).any())  # of one sample it is all 0
    return Picture(mean, noise if told else None)


def triple(channels: Mapping[str, Float32], layer: str) -> tuple[Float32, ...] | None:
    """Red, green and blue of the first layer of that name ("": of no layer), or None."""
    for names in ("RGB", "XYZ", "rgb"):
        for first in channels:
            head, _, last = first.rpartition(".")
            if last == names[0] and (head == layer or (layer and head.endswith(f".{layer}"))):
                found = [channels.get(f"{head}.{c}" if head else c) for c in names]
                if all(channel is not None for channel in found):
                    return tuple(channel for channel in found if channel is not None)
    return None


def compare_files(a: Path, b: Path) -> dict[str, Any]:
    """What `compare A.exr B.exr` tells, ready for JSON; B is the reference.

    Raises
    ------
    ValueError
        A file can't be read, or they differ in size.
    """
    first, second = picture_of(a), picture_of(b)
    if first.mean.shape != second.mean.shape:
        sizes = " and ".join(f"{p.mean.shape[1]}x{p.mean.shape[0]}" for p in (first, second))
        raise ValueError(f"the images differ in size: {sizes}")
    plain = Picture(second.mean, None)
    found: dict[str, Any] = {
        "images": [str(a), str(b)],
        "mse": mse(first.mean, plain),
        "relmse": relative_mse(first.mean, plain),
        "mean": [float(first.mean.mean()), float(second.mean.mean())],
        "flip": None,
        "flip_missing": "",
        "z": None,
        "worst": None,
        "p": None,
    }
    try:
        found["flip"] = flip(first.mean, second.mean)
    except MissingPackage as problem:
        found["flip_missing"] = str(problem)
    if first.variance is not None or second.variance is not None:
        test = bias(first, second)
        found |= {"z": test.z, "worst": test.worst, "p": test.p}
    return found


def flip(image: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Mean HDR-FLIP (Andersson et al. 2021): what an eye notices when flipping between the two."""
    evaluator = optional("flip_evaluator", "flip-evaluator", "FLIP")
    hdr = [np.ascontiguousarray(np.maximum(x, 0), np.float32) for x in (reference, image)]
    if not hdr[0].any():
        return 0.0 if not hdr[1].any() else 1.0  # black has no exposure to look at it by
    return float(evaluator.evaluate(*hdr, "HDR", applyMagma=False)[1])


def lines(found: Mapping[str, Any]) -> list[str]:
    """The comparison for a terminal."""
    a, b = found["images"]
    text = [
        f"{a} against {b}",
        f"  MSE     {found['mse']:.4g}",
        f"  relMSE  {found['relmse']:.4g}  ({found['relmse'] ** 0.5:.2%} relative RMS)",
        f"  mean    {found['mean'][0]:.5g} and {found['mean'][1]:.5g}",
        f"  FLIP    {found['flip']:.4f}"
        if found["flip"] is not None
        else f"  FLIP    {found['flip_missing']}",
    ]
    if found["z"] is None:
        text.append(f"  z-test  none: neither file has a pass {NOISE} that knows it")
        text.append("          (render --passes writes it)")
    else:
        verdict = "they differ by more than noise" if found["p"] < 1e-3 else "they differ as noise does"
        z = f"z = {found['z']:.2f}"
        if abs(found["worst"]) > abs(found["z"]):
            z += f", {found['worst']:.2f} in a part of the image"
        text.append(f"  z-test  {z}, p = {found['p']:.2g}: {verdict}")
    return text
