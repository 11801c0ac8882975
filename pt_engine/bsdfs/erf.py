"""The error function, scaled complement and inverse, in float32 by plain arithmetic (numpy has none)."""

from __future__ import annotations

import numpy as np

from .base import Float32

# Abramowitz and Stegun 7.1.26, |error of erf| ≤ 1.5e-7: erfc(x) = (a₁t + … + a₅t⁵) exp(−x²), t = 1/(1 + px)
P = 0.3275911
A = (0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429)

# Giles 2010, "Approximating the erfinv function": w = −log(1 − x²), polynomials for w < 5 and above
CENTRAL = (
    2.81022636e-08, 3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087,
    -0.00125372503, -0.00417768164, 0.246640727, 1.50140941,
)  # fmt: skip
TAIL = (
    -0.000200214257, 0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773,
    -0.0076224613, 0.00943887047, 1.00167406, 2.83297682,
)  # fmt: skip


def erfc_scaled(x: Float32) -> Float32:
    """exp(x²) erfc(x) for x ≥ 0."""
    t = 1.0 / (1.0 + P * x)
    scaled: Float32 = ((((A[4] * t + A[3]) * t + A[2]) * t + A[1]) * t + A[0]) * t
    return scaled


def erf(x: Float32) -> Float32:
    """erf(x) for x ≥ 0."""
    value: Float32 = 1.0 - erfc_scaled(x) * np.exp(-x * x)
    return value


def inverse_erf(y: Float32) -> Float32:
    """x with erf(x) = y for |y| ≤ 1; ±1 give ±3.83, the last finite value of float32."""
    w = -np.log(np.maximum((1.0 - y) * (1.0 + y), 1.2e-7))
    central: Float32 = np.minimum(w, 5.0)
    tail: Float32 = np.sqrt(np.maximum(w, 5.0))
    central -= 2.5
    tail -= 3.0
    above = w >= 5.0
    c, t = _horner(CENTRAL, central), _horner(TAIL, tail)
    x: Float32 = y * (c + (t - c) * above)
    return x


def _horner(coefficients: tuple[float, ...], x: Float32) -> Float32:
    total = x * coefficients[0] + coefficients[1]
    for coefficient in coefficients[2:]:
        total = total * x + coefficient
    return total
