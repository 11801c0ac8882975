"""Glass through which a transparent film shows: rays that it lets pass still see the film, as in Cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import Lobe

if TYPE_CHECKING:
    from .shading import ClosureLike

Float32 = NDArray[np.float32]
UInt8 = NDArray[np.uint8]


def clear(closure: ClosureLike, index: NDArray[np.intp] | slice, lobe: UInt8 | int, limit: float) -> UInt8:
    """(K,) the lobes sampled on the lanes `index`, marked where they pass glass as smooth as `limit`.

    Cycles compares α_x α_y, α the square of the roughness; a Dirac lobe has none.
    """
    lobes = np.asarray(lobe, np.uint8)
    through = (lobes & Lobe.TRANSMIT != 0) & (lobes & (Lobe.DIFFUSE | Lobe.TRANSPARENT) == 0)
    alpha = getattr(closure.params, "alpha", None)
    if alpha is None:
        smooth = lobes & Lobe.DELTA != 0
    else:
        own = alpha if np.ndim(alpha) == 0 or np.shape(alpha)[-1] == 1 else alpha[..., index]
        smooth = (np.square(own) <= limit**4) | (lobes & Lobe.DELTA != 0)
    return np.asarray(lobes | np.uint8(Lobe.CLEAR) * (through & smooth), np.uint8)
