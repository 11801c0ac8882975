"""Fourier transforms of the colour channels' sensitivities, by which thin films interfere (see `thin_film`).

    S(D) = ∫ s(1/λ) exp(−2πi D/λ) d(1/λ) / ∫ s d(1/λ)        s(1/λ) = λ² x̄(λ), and so on

x̄ ȳ z̄ are the CIE 1931 colour-matching functions of the 2° observer, made to Rec.709 by its matrix. They are
taken, as Cycles has them, at the wave numbers 1/λ = kπ/60 µm⁻¹, where k = 23 to 53 is all that is seen; so
the integral is a sum of 31 terms, which repeats only beyond 19 µm. It is tabulated for D up to 60/2π µm.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

NODES: Final = 512
REACH: Final = 60_000.0 / (2.0 * np.pi)  # nm, the path difference of the last node
FIRST: Final = 23
STEP: Final = np.pi / 60.0  # µm⁻¹

X: Final = (
    0.000001, 0.000014, 0.000126, 0.001033, 0.006921, 0.040611, 0.179205, 0.510761, 0.921889, 1.061533,
    0.898684, 0.623337, 0.369378, 0.171558, 0.035896, 0.002597, 0.033265, 0.11821, 0.242763, 0.319885,
    0.34913, 0.322077, 0.205367, 0.079305, 0.027408, 0.011261, 0.004126, 0.001638, 0.000695, 0.000303,
    0.000141,
)  # fmt: skip
Y: Final = (
    0.0, 0.000005, 0.000046, 0.000373, 0.002499, 0.01474, 0.066434, 0.202797, 0.42807, 0.671629,
    0.882216, 0.990578, 0.982909, 0.868185, 0.633099, 0.364723, 0.205454, 0.125127, 0.076443, 0.047406,
    0.02857, 0.01578, 0.006854, 0.002229, 0.000758, 0.000314, 0.000117, 0.000047, 0.000021, 0.000009,
    0.000004,
)  # fmt: skip
Z: Final = (
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.000026, 0.000229, 0.000937, 0.001691, 0.003438, 0.012654,
    0.04078, 0.102575, 0.23946, 0.472855, 0.92589, 1.494079, 1.746581, 1.780888, 1.587253, 0.992682,
    0.379362, 0.13035, 0.053356, 0.019497, 0.007726, 0.003266, 0.001419, 0.000658,
)  # fmt: skip
XYZ_TO_REC709: Final = (
    (3.2409699, -1.5373832, -0.4986108),
    (-0.9692436, 1.8759675, 0.0415551),
    (0.0556301, -0.2039770, 1.0569715),
)


def transforms() -> NDArray[np.complex128]:
    """(3, NODES): S of red, green and blue at path differences 0 to `REACH`; 1 at 0."""
    wave_numbers = STEP * np.arange(FIRST, FIRST + len(X))
    sensitivity = np.array(XYZ_TO_REC709) @ (np.array([X, Y, Z]) / wave_numbers**2)
    paths = np.linspace(0.0, REACH / 1000.0, NODES)
    waves = np.exp(-2j * np.pi * np.outer(wave_numbers, paths))
    table: NDArray[np.complex128] = (sensitivity @ waves) / sensitivity.sum(axis=1, keepdims=True)
    return table
