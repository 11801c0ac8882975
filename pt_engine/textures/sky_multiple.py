"""The sky by multiple scattering: radiance of the whole sphere and of the sun, in CIE XYZ.

García Liñán, *Physically Based Real-Time Rendering of Atmospheres using Ray Tracing* (2022) and *An
efficient spectral sky* (2024): four wavelengths stand for the spectrum, scattering of second and higher
order is a fit, the rest one march along the view ray,

    L = Σ Tr(A→B) · σₛ · (phase · Tr(B→sun) + multiple) · E_sun

Kilometres. Blender tabulates the sky once in 512 × 256 directions and looks up between them; so does this,
with its steps and in its order of operations: at Earth's radius a float32 has half a metre, which shows.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Number = Float32 | np.float32
F = np.float32

WIDTH: Final = 512
HEIGHT: Final = 256
EARTH: Final = F(6371)  # radius
THICKNESS: Final = F(100)
TOP: Final = F(EARTH + THICKNESS)
STEPS: Final = 64
COSINES: Final = 256  # of the table of transmittances to the sun
ALTITUDES: Final = 64
ROWS_AT_ONCE: Final = 1  # of directions: their work arrays stay in the cache
PI: Final = F(np.pi)


def _spectrum(*values: float) -> Float32:
    """Values at 630, 560, 490 and 430 nm, to multiply arrays (4, ...) with."""
    return np.array(values, np.float32)


ALBEDO: Final = F(0.3)  # of the ground
SUN: Final = _spectrum(1.679, 1.828, 1.986, 1.307)  # irradiance above the atmosphere
MOLECULES: Final = _spectrum(6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2)  # scattering at sea level
OZONE: Final = _spectrum(3.472e-25, 3.914e-25, 1.349e-25, 11.03e-27)  # absorption cross-section
DOBSON: Final = F(334.5)
AEROSOL_ABSORPTION: Final = _spectrum(2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23)  # urban air
AEROSOL_SCATTERING: Final = _spectrum(1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22)
AEROSOL_BASE: Final = F(1.3681e20)
AEROSOL_BACKGROUND: Final = F(2e6)
AEROSOL_HEIGHT: Final = F(0.73)
MULTIPLE: Final = F(0.02) * _spectrum(0.217, 0.347, 0.594, 1.0)
G: Final = F(0.8)
TO_XYZ: Final = np.array(
    [
        [53.386917738564668, 43.904844466369358, 1.6137278251608962, 20.762668673810577],
        [22.981337506691025, 71.347795700053394, 18.422960591455485, 2.3614213523314368],
        [0.0, 0.10250686796574131, 31.742921188390806, 110.48009643252140],
    ],
    np.float32,
)


class Air(NamedTuple):
    """Densities relative to Earth's."""

    molecules: float
    aerosols: float
    ozone: float


def xyz(spectrum: Float32) -> Float32:
    """(3, ...) of (4, ...)."""
    out = np.zeros((3, *spectrum.shape[1:]), np.float32)
    for k in range(4):
        for axis in range(3):
            out[axis] += TO_XYZ[axis, k] * spectrum[k]
    return out


def coefficients(altitude: Float32, air: Air) -> tuple[Float32, Float32, Float32]:
    """(4, ...) extinction, and scattering by molecules and by aerosols, km⁻¹."""
    log = np.log(np.maximum(altitude, F(1e-4)))
    ozone = F(3.78547397e20) * np.exp(-np.square(log - F(3.22261)) * F(5.55555555) - log)
    molecules = np.exp(F(-0.07771971) * altitude ** F(1.16364243))
    aerosols = AEROSOL_BASE * (np.exp(-altitude / AEROSOL_HEIGHT) + AEROSOL_BACKGROUND / AEROSOL_BASE)
    aerosols *= F(air.aerosols)
    shape = (4, *altitude.shape)
    extinction, by_molecules, by_aerosols = (np.empty(shape, np.float32) for _ in range(3))
    for k in range(4):
        np.multiply(AEROSOL_SCATTERING[k], aerosols, out=by_aerosols[k])
        np.multiply(MOLECULES[k], molecules, out=by_molecules[k])
        by_molecules[k] *= F(air.molecules)
        extinction[k] = AEROSOL_ABSORPTION[k] * aerosols
        extinction[k] += by_aerosols[k]
        extinction[k] += OZONE[k] * DOBSON * ozone * F(air.ozone)
        extinction[k] += by_molecules[k]
    return extinction, by_molecules, by_aerosols


def sine(angle: Number) -> Float32:
    """Correctly rounded, as C's sinf and unlike numpy's: near the horizon the last bit counts."""
    return np.sin(np.float64(angle)).astype(np.float32)  # type: ignore[no-any-return]


def cosine_of(angle: Number) -> Float32:
    """Correctly rounded."""
    return np.cos(np.float64(angle)).astype(np.float32)  # type: ignore[no-any-return]


def length(x: Float32, y: Number, z: Float32) -> Float32:
    """Euclidean, in the order x, y, z."""
    out: Float32 = np.sqrt(x * x + y * y + z * z)
    return out


def sphere_distance(height: Number, up: Float32, radius: np.float32) -> Float32:
    """From a point at `height` over the centre along a ray of vertical component `up` to a sphere; or −1."""
    b = height * up
    c = height * height - radius * radius
    d = b * b - c
    root = np.sqrt(np.maximum(d, F(0)))
    t = np.where(d >= b * b, root - b, -b - root)
    return np.where(((c > 0) & (b > 0)) | (d < 0), F(-1), t)


def transmittance(cosine: Float32, altitude: Float32, air: Air) -> Float32:
    """(4, n) along rays of vertical component `cosine`, from an altitude (0 ground, 1 top) to space."""
    height = EARTH + altitude * (TOP - EARTH)
    side = -np.sqrt(1 - cosine * cosine)
    step = sphere_distance(height, cosine, TOP) / F(STEPS)
    depth = np.zeros((4, *np.broadcast_shapes(cosine.shape, altitude.shape)), np.float32)
    for k in range(STEPS):
        t = F(k + 0.5) * step
        above = np.maximum(length(side * t, F(0), height + cosine * t) - EARTH, F(0))
        depth += coefficients(above, air)[0] * step
    return np.exp(-depth)


class Transmittances:
    """Transmittance to the sun, tabulated by the sun's cosine and by altitude."""

    def __init__(self, air: Air) -> None:
        cosine = np.arange(COSINES, dtype=np.float32) / F(COSINES - 1) * 2 - 1
        altitude = np.arange(ALTITUDES, dtype=np.float32) / F(ALTITUDES - 1)
        table = transmittance(cosine[None], altitude[:, None], air)  # (4, altitude, cosine)
        self._rows = np.ascontiguousarray(table.reshape(4, -1).T)
        self._at_ground = np.ascontiguousarray(table[:, 0].T)
        self._overhead = np.ascontiguousarray(table[:, :, -1].T)

    def at(self, cosine: Float32, altitude: Float32) -> Float32:
        """(4, ...) bilinear."""
        column, fx = place(cosine * F(0.5) + F(0.5), COSINES)
        row, fy = place(altitude, ALTITUDES)
        right = np.minimum(column + 1, COSINES - 1)
        low = row * COSINES
        high = np.minimum(row + 1, ALTITUDES - 1) * COSINES
        a, b = (
            between(spectra(self._rows, line + column), spectra(self._rows, line + right), fx)
            for line in (low, high)
        )
        return between(a, b, fy)

    def at_ground(self, cosine: Float32) -> Float32:
        """(4, ...) at altitude 0."""
        return self._line(self._at_ground, *place(cosine * F(0.5) + F(0.5), COSINES))

    def overhead(self, altitude: Float32) -> Float32:
        """(4, ...) with the sun in the zenith."""
        return self._line(self._overhead, *place(altitude, ALTITUDES))

    @staticmethod
    def _line(rows: Float32, index: Int32, part: Float32) -> Float32:
        following = np.minimum(index + 1, len(rows) - 1)
        return between(spectra(rows, index), spectra(rows, following), part)


def place(x: Float32, size: int) -> tuple[Int32, Float32]:
    """Entry of a table over [0, 1] below x, and how far above it x is."""
    at = F(size - 1) * np.clip(x, F(0), F(1))
    index = at.astype(np.int32)
    return index, at - index


def spectra(rows: Float32, index: Int32) -> Float32:
    """(4, ...) of a table (K, 4)."""
    return np.ascontiguousarray(np.moveaxis(rows.take(index, axis=0, mode="clip"), -1, 0))


def between(a: Float32, b: Float32, part: Float32) -> Float32:
    """a + part·(b − a), in the memory of b."""
    b -= a
    b *= part
    b += a
    return b


def rescattered(sun: Transmittances, cosine: Float32, altitude: Float32, d: Float32) -> Float32:
    """(4, ...) light from the ground and from elsewhere in the atmosphere, per unit of the sun's."""
    omega = 2 * PI * (1 - np.sqrt(np.maximum(1 - np.square(EARTH / d), F(0))))
    up = sun.overhead(np.zeros(1, np.float32)).reshape(4, *[1] * cosine.ndim) / sun.overhead(altitude)
    ground = sun.at_ground(cosine)
    ground *= F(0.25) / PI * omega * (ALBEDO / PI)
    ground *= up
    ground *= cosine
    fit = 1 / (1 + 5 * np.exp(F(-17.92) * cosine))
    for k in range(4):
        ground[k] += MULTIPLE[k] * fit
    return ground


def inscattering(sun: Transmittances, sun_up: Number, origin: np.float32, d: Float32, air: Air) -> Float32:
    """(4, n) radiance along unit directions d (3, n) at a height over Earth's centre."""
    sun_side = -np.sqrt(1 - sun_up * sun_up)
    ground = sphere_distance(origin, d[2], EARTH)
    step = np.where(ground < 0, sphere_distance(origin, d[2], TOP), ground) / F(STEPS)
    t = (np.arange(STEPS, dtype=np.float32) + F(0.5))[:, None] * step
    x, y, z = d[0] * t, d[1] * t, origin + d[2] * t
    far = length(x, y, z)
    above = np.maximum(far - EARTH, F(0))
    altitude = above / THICKNESS
    cosine = x / far * sun_side + z / far * sun_up
    extinction, by_molecules, by_aerosols = coefficients(above, air)
    direct = sun.at(cosine, altitude)
    more = rescattered(sun, cosine, altitude, far)
    toward = -d[0] * sun_side - d[2] * sun_up
    molecule_phase = F(3 / 16) / PI * (1 + toward * toward)
    den = 1 + G * G + 2 * G * toward
    aerosol_phase = F(0.25) / PI * (1 - G * G) / (den * np.sqrt(den))
    source = molecule_phase * direct
    source += more
    source *= by_molecules
    direct *= aerosol_phase
    direct += more
    direct *= by_aerosols
    source += direct
    source *= SUN[:, None, None]
    passes = np.exp(-step * extinction)
    # each segment's light is integrated in closed form (Hillaire 2015)
    source -= source * passes
    source /= np.maximum(extinction, F(1e-7))
    light = np.zeros((4, d.shape[1]), np.float32)
    through = np.ones_like(light)
    for k in range(STEPS):
        light += through * source[:, k]
        through *= passes[:, k]
    return light


def sky(sun_elevation: float, altitude: float, air: Air) -> Float32:
    """(HEIGHT, WIDTH, 3) XYZ radiance, rows from nadir to zenith, denser at the horizon.

    Elevation = ±l²·π/2 with l from −1 to 1; azimuth from 0 to 2π, the sun's being π.
    """
    sun = Transmittances(air)
    sun_up = cosine_of(F(np.pi / 2) - F(sun_elevation))
    origin = EARTH + F(min(max(altitude, 1.0), 99999.0)) / F(1000)
    azimuth = 2 * PI * ((np.arange(WIDTH // 2, dtype=np.float32) + F(0.5)) / F(WIDTH))
    line = (np.arange(HEIGHT, dtype=np.float32) + F(0.5)) / F(HEIGHT) * 2 - 1
    elevation = np.copysign(line * line, line) * F(np.pi / 2)
    out = np.empty((HEIGHT, WIDTH, 3), np.float32)
    for first in range(0, HEIGHT, ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        e, a = np.broadcast_arrays(elevation[rows, None], azimuth)
        d = np.stack([cosine_of(e) * cosine_of(a), cosine_of(e) * sine(a), sine(e)]).reshape(3, -1)
        half = xyz(inscattering(sun, sun_up, origin, d, air)).reshape(3, *e.shape).transpose(1, 2, 0)
        out[rows, : WIDTH // 2], out[rows, WIDTH // 2 :] = half, half[:, ::-1]
    return out


def sun_disc(elevation: float, diameter: float, altitude: float, air: Air) -> tuple[Float32, Float32]:
    """(3,) XYZ radiance at the bottom and at the top of the sun's disc."""
    half = F(diameter) / 2
    solid_angle = 2 * PI * (1 - cosine_of(half))
    height = F(min(max(altitude, 1.0), 99999.0)) / F(1000) / THICKNESS
    ends = F(elevation) + np.array([-half, half], np.float32)
    through = transmittance(cosine_of(F(np.pi / 2) - ends), np.full(2, height, np.float32), air)
    bottom, top = xyz(SUN[:, None] * through / solid_angle).T
    return bottom, top
