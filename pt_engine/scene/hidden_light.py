"""Which closures see light that is hidden from some kinds of scattering, as Cycles sorts them.

A sampled direction belongs to all closures at once, so each of them is asked. What both reflects and lets
through is left out only where both are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .snapshot import Visibility

if TYPE_CHECKING:
    from ..bsdfs.base import BSDF

GLASS = {"dielectric", "dielectric_beckmann"}
GLOSSY = {"velvet", "toon_glossy", "hair_reflection", "hair_chiang", "hair_huang"}
COATED = {"plastic"}


def sees(bsdf: BSDF, hidden: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """(N,) whether a closure of this model takes light that is `hidden` (N,) from some."""
    mask = np.uint8(_kind(bsdf))
    seen: NDArray[np.bool_] = (hidden & mask) != mask
    return seen


def _kind(model: BSDF) -> int:
    """`Visibility` bits that must all be hidden for the closure to see nothing."""
    name = getattr(model, "__name__", "").rpartition(".")[2]
    if name in GLASS:
        return Visibility.GLOSSY | Visibility.TRANSMISSION
    if name in COATED:
        return Visibility.DIFFUSE | Visibility.GLOSSY
    if name in GLOSSY:
        return Visibility.GLOSSY
    if getattr(model, "SPECULAR", False):
        return Visibility.TRANSMISSION if getattr(model, "TRANSMITS", False) else Visibility.GLOSSY
    return Visibility.DIFFUSE
