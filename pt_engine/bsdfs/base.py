"""What every scattering model is: a module with three functions, in one local frame.

The local frame has +Z along the shading normal on the viewer's side, so `wi[2] ≥ 0` but for the few
lanes where an interpolated normal turns away from the viewer. Reflection has `wo[2] > 0`, transmission
`wo[2] < 0`; a model that needs to know inside from outside gets its relative index from the caller.

A model is a module with

    class Params(NamedTuple)                     its arrays, each (N,), (3, N), or broadcastable (1,), (3, 1)
    eval_pdf(params, wi, wo) -> value, pdf       f·|cosθo| (3, N) or (1, N), density (N,); 0 for a delta lobe
    sample(params, wi, u0, u1, u2) -> BSDFSample u0 chooses the lobe, u1 and u2 the direction
    albedo(params, cos_i) -> (N,) or (1,)        how much it reflects, roughly: guides the choice of closure
    SPECULAR, TRANSMITS: bool                    optional: its normal is raised so that a mirror's would
                                                 reflect, no bump dims it (`scene.shading`); light passes

`value` is sr⁻¹. Random numbers are in [0, 1). `weight` is f·|cosθo|/pdf, in closed form where it cancels.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
UInt8 = NDArray[np.uint8]


class Lobe:
    """What kind of scattering a sample was (bits)."""

    DIFFUSE, GLOSSY, DELTA, TRANSMIT, TRANSPARENT, PORTAL = 1, 2, 4, 8, 16, 32
    CLEAR = 64  # passed glass that shows a transparent film; no model sets it
    NONE = 0


class BSDFSample(NamedTuple):
    """A sampled direction.

    Attributes
    ----------
    wo : (3, N) float32
        Unit, local frame. Undefined where weight is 0.
    pdf : (N,) float32
        Per solid angle; of a delta lobe, the probability with which the lobe was chosen.
    weight : (3, N) or (1, N) float32
        f·|cosθo|/pdf; 0 where the sample failed.
    lobe : (N,) uint8 or int
        Bits of `Lobe`.
    eta : (N,) float32 or float
        Index of the side wo points into over the side wi is on; 1 for reflection.
    """

    wo: Float32
    pdf: Float32
    weight: Float32
    lobe: UInt8 | int
    eta: Float32 | float = 1.0


P = TypeVar("P", bound=tuple)  # type: ignore[type-arg]


class BSDF(Protocol):
    """The module contract, for the type checker."""

    def eval_pdf(self, params: tuple, wi: Float32, wo: Float32) -> tuple[Float32, Float32]: ...  # type: ignore[type-arg]
    def sample(
        self,
        params: tuple,  # type: ignore[type-arg]
        wi: Float32,
        u0: Float32,
        u1: Float32,
        u2: Float32,
    ) -> BSDFSample: ...
    def albedo(self, params: tuple, cos_i: Float32) -> Float32: ...  # type: ignore[type-arg]


def gather(params: P, index: NDArray[np.intp]) -> P:
    """The parameters of some lanes; broadcast ones (last axis 1, or scalars) stay as they are."""
    return type(params)(
        *(
            value if np.ndim(value) == 0 or value.shape[-1] == 1 else value.take(index, axis=-1)
            for value in params
        )
    )
