"""Makes pt_engine/textures/hosek.npz: Hosek's and Wilkie's sky, measured in Blender's pictures of it.

    python tools/measure_hosek.py [folder for the result]

needs the bpy wheel and scipy, and some minutes. What is fitted is the formula of pt_engine/textures/hosek.py:

1. Each sky alone, for A, B, E and H; the others are linear (variable projection).
2. The curves through all elevations at one whole turbidity and an albedo of 0 or 1: "a corner".
3. A corner's radiance does not tell how large M is, only M times C, D, ...: skies between corners do.
4. All corners together, by Gauss and Newton.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import product
from math import comb
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

ROOT = Path(__file__).resolve().parents[1]
TURBIDITIES = np.arange(1, 10.01, 0.5)
ALBEDOS = (0.0, 0.5, 1.0)
PLACES = np.linspace(0, 1, 13)  # ∛(elevation / 90°)
SKIES = [(t, a, x) for t in TURBIDITIES for a in ALBEDOS for x in PLACES]
NUMBER = {sky: k for k, sky in enumerate(SKIES)}
BEZIER = np.array([[comb(5, k) * (1 - x) ** (5 - k) * x**k for k in range(6)] for x in PLACES])
A, B, C, D, E, F_, G, ZENITH, H, M = range(10)  # rows of a corner; ZENITH is I
LINEAR = [C, D, F_, G, ZENITH]
GOOD = 2e-6  # RMS error of a corner, all that float32 leaves
CLOSE = 0.03  # nearer to the sun than this many radians float32 has too few digits
TO_XYZ = np.linalg.inv([[3.2409699, -1.5373832, -0.4986108], [-0.9692436, 1.8759675, 0.0415551], [0.0556301, -0.2039770, 1.0569715]])  # fmt: skip  # noqa: E501


def measured() -> tuple[np.ndarray, np.ndarray]:
    """Directions (K, 3, n), dense around the sun, and Blender's Rec.709 radiance of each of `SKIES`."""
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    from support import cycles_nodes
    from support.bpy_scenes import empty_scene

    empty_scene()
    rng, n, directions = np.random.default_rng(0), cycles_nodes.SIDE**2, []
    for k, (turbidity, albedo, x) in enumerate(SKIES):
        theta, phi = np.arccos(rng.uniform(0, 1, n) ** 1.5), rng.uniform(0, 2 * np.pi, n)
        d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        d[:, ::4] = toward_sun(x)[:, None] + d[:, ::4] * rng.uniform(0.1, 1, d[:, ::4].shape[1])
        d[2] = np.maximum(d[2], 1e-3)
        directions.append((d / np.sqrt((d * d).sum(axis=0))).astype(np.float32))
        sheet = cycles_nodes.sheet(str(k), {"A": directions[-1]}, *cycles_nodes.place(k, len(SKIES)))
        settings = {
            "sky_type": "HOSEK_WILKIE",
            "turbidity": turbidity,
            "ground_albedo": albedo,
            "sun_direction": tuple(toward_sun(x)),
        }
        sheet.data.materials.append(
            cycles_nodes.material(str(k), "TexSky", settings, {"Vector": "A"}, "Color")
        )
    picture = cycles_nodes.render(len(SKIES))
    return np.stack(directions), np.stack(
        [cycles_nodes.cut(picture, k, len(SKIES)) for k in range(len(SKIES))]
    )


def toward_sun(x: float) -> np.ndarray:
    """Unit direction for a place on the curve."""
    elevation = x**3 * np.pi / 2
    return np.array([0.0, np.cos(elevation), np.sin(elevation)])


class Data:
    """What was measured of one channel: per sky cosθ, γ and radiance, where all three are good."""

    def __init__(self, directions: np.ndarray, rgb: np.ndarray, channel: int) -> None:
        self.up, self.gamma, self.value = [], [], []
        for (_, _, x), d, c in zip(SKIES, directions.astype(float), rgb.astype(float), strict=True):
            sun = toward_sun(x).astype(np.float32).astype(float)
            gamma = np.arccos(np.clip(sun @ d, -1, 1))
            good = (c > 0).all(axis=0) & (gamma > CLOSE)
            theta = np.minimum(np.arccos(d[2]), np.pi / 2 - 0.001)
            self.up.append(np.cos(theta)[good])
            self.gamma.append(gamma[good])
            self.value.append((TO_XYZ[channel] @ c)[good] * 683 / (2 * np.pi))


def terms(up: np.ndarray, gamma: np.ndarray, e: float, h: float) -> np.ndarray:
    """(5, n) what C, D, F, G and I multiply."""
    c = np.cos(gamma)
    chi = (1 + c * c) / (1 + h * h - 2 * h * c) ** 1.5
    return np.stack([np.ones_like(gamma), np.exp(e * gamma), c * c, chi, np.sqrt(up)])


def residuals(data: Data, k: int, rows: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors (n,) of sky k, and their derivatives (n, 60), for a corner's rows (10, 6)."""
    p, up, gamma, value = rows @ weights, data.up[k], data.gamma[k], data.value[k]
    t, c = terms(up, gamma, p[E], p[H]), np.cos(gamma)
    horizon = np.exp(p[B] / (up + 0.01))
    front, glow = 1 + p[A] * horizon, p[LINEAR] @ t
    q = 1 + p[H] ** 2 - 2 * p[H] * c
    by = np.empty((10, value.size))
    by[A], by[B] = horizon * glow, p[A] * horizon / (up + 0.01) * glow
    by[LINEAR] = front * t
    by[E] = front * p[D] * gamma * t[1]
    by[H] = front * p[G] * (1 + c * c) * -1.5 * q**-2.5 * (2 * p[H] - 2 * c)
    by[:M] *= p[M]
    by[M] = front * glow
    return front * glow * p[M] / value - 1, ((by / value)[:, None] * weights[:, None]).reshape(60, -1).T


def one_sky(data: Data, k: int, near: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """A, B, E, H of one sky, and M times C, D, F, G, I; `near` are those of the next one."""
    up, gamma, value = data.up[k], data.gamma[k], data.value[k]

    def solved(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        front = 1 + p[0] * np.exp(p[1] / (up + 0.01))
        matrix = (terms(up, gamma, p[2], p[3]) * front / value).T
        linear = np.linalg.lstsq(matrix, np.ones(len(value)), rcond=1e-13)[0]
        return linear, matrix @ linear - 1

    low, high = np.array([-50, -20, -20, -0.2]), np.array([20, 5, 2, 0.999])
    rng = np.random.default_rng(k)
    starts = [] if near is None else [near]
    starts += [np.array(s) for s in ((-1, -0.3, -2, 0.6), (-1.1, -0.15, -4, 0.8), (-1.1, -0.2, -0.5, 0.7), (-1.2, -0.2, 0.5, 0.7))]  # fmt: skip  # noqa: E501
    starts += [rng.uniform([-1.5, -2, -6, 0.1], [-0.5, 0, 0, 0.9]) for _ in range(4)]
    best = None
    for start in starts:
        start = np.clip(start, low + 1e-6, high - 1e-6)
        found = least_squares(
            lambda p: solved(p)[1], start, bounds=(low, high), x_scale=[1, 0.3, 1, 0.2],
            max_nfev=150, xtol=1e-14, ftol=1e-14, gtol=1e-14,
        )  # fmt: skip
        best = found if best is None or found.cost < best.cost else best
        if best.cost < 1e-9:
            break
    return best.x, solved(best.x)[0]


def curve(values: np.ndarray) -> np.ndarray:
    """Control points of the quintic through values at `PLACES`."""
    return np.linalg.lstsq(BEZIER, values, rcond=None)[0]


def starting_corners(alone: list, bright: np.ndarray, known: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Rows (10, 6) to begin with: M of several shapes, or that of corners that are known already."""
    four, linear = np.array([s[0] for s in alone]), np.array([s[1] for s in alone])
    fixed = {row: curve(four[:, k]) for k, row in enumerate((A, B, E, H))}

    def errors(v: np.ndarray) -> np.ndarray:
        m, others = BEZIER @ v[:6], BEZIER @ v[6:].reshape(5, 6).T
        return ((m[:, None] * others - linear) / (0.01 * np.abs(linear) + 0.02 * bright[:, None])).ravel()

    shapes = [bright, np.full_like(bright, bright.mean()), linear[:, 4], np.abs(linear[:, 2]) + 0.1 * bright]
    shapes.append(bright * (0.2 + PLACES))
    for m in [curve(s) for s in shapes] + [rows[M] for rows in known]:
        others = [curve(linear[:, k] / (BEZIER @ m)) for k in range(5)]
        v = least_squares(errors, np.concatenate([m, *others]), max_nfev=300).x.reshape(6, 6)
        yield np.stack([fixed[row] if row in fixed else v[0 if row == M else 1 + LINEAR.index(row)] for row in range(10)])  # fmt: skip  # noqa: E501
    yield from known


def corner(data: Data, turbidity: float, albedo: float, known: list[np.ndarray]) -> tuple[np.ndarray, float]:
    """The rows (10, 6) of a corner and their RMS error."""
    numbers = [NUMBER[turbidity, albedo, x] for x in PLACES]
    alone: list = []
    for k in reversed(numbers):
        alone.append(one_sky(data, k, alone[-1][0] if alone else None))
    bright = np.array([data.value[k].mean() for k in numbers])

    def both(v: np.ndarray) -> list[np.ndarray]:
        parts = [residuals(data, k, v.reshape(10, 6), w) for k, w in zip(numbers, BEZIER, strict=True)]
        return [np.nan_to_num(np.concatenate(p), nan=1e3, posinf=1e3, neginf=-1e3) for p in zip(*parts, strict=True)]  # fmt: skip  # noqa: E501

    best, error = np.zeros((10, 6)), np.inf
    for start in starting_corners(alone[::-1], bright, known):
        found = least_squares(
            lambda v: both(v)[0], start.ravel(), lambda v: both(v)[1], method="lm", x_scale="jac",
            xtol=1e-15, ftol=1e-12, gtol=1e-15, max_nfev=150,
        )  # fmt: skip
        rms = float(np.sqrt(2 * found.cost / len(found.fun)))
        if rms < error:
            best, error = found.x.reshape(10, 6), rms
        if error < GOOD:
            break
    return best, error


def corners_of(data: Data) -> np.ndarray:
    """All corners (10, 2, 10, 6), each with the help of those neighbours that are known by then."""
    corners, error = np.zeros((10, 2, 10, 6)), np.full((10, 2), np.inf)
    for _, a, t in product(range(3), range(2), range(10)):
        if error[t, a] < GOOD:
            continue
        near = [(t - 1, a), (t + 1, a), (t, 1 - a), (t + 2, a), (t - 2, a)]
        known = [corners[i, b] for i, b in near if 0 <= i < 10 and error[i, b] < GOOD]
        corners[t, a], error[t, a] = corner(data, t + 1.0, float(a), known)
        print(f"turbidity {t + 1}, albedo {a}: {error[t, a]:.2g}", flush=True)
    return corners


def mixture(turbidity: float, albedo: float) -> list[tuple[int, int, float]]:
    """Which corners a sky is made of, and their shares."""
    low, part = int(turbidity), turbidity % 1
    pairs = product(((low - 1, 1 - part), (low, part)), ((0, 1 - albedo), (1, albedo)))
    return [(t, a, u * v) for (t, u), (a, v) in pairs if u * v > 0]


def scaled(corners: np.ndarray, logarithms: np.ndarray) -> np.ndarray:
    """Corners with M divided, and C, D, F, G, I multiplied, by a factor each."""
    out, factor = corners.copy(), np.exp(logarithms).reshape(10, 2, 1)
    out[:, :, LINEAR] *= factor[..., None]
    out[:, :, M] /= factor
    return out


def with_scales(data: Data, corners: np.ndarray) -> np.ndarray:
    """Corners whose M have the sizes that skies between them show."""
    middle = corners[:, :, M] @ BEZIER[6]
    corners = corners.copy()
    corners[:, :, [*LINEAR, M]] *= np.sign(middle)[:, :, None, None]
    start = np.log(np.abs(middle) / abs(middle[0, 0])).ravel()
    some = [k for k, (t, a, x) in enumerate(SKIES) if (a == 0.5 or t % 1) and x in PLACES[1:11:3]]

    def errors(v: np.ndarray) -> np.ndarray:
        now, out = scaled(corners, np.concatenate([[0.0], v])), []
        for k in some:
            rows = sum(w * now[t, a] for t, a, w in mixture(*SKIES[k][:2]))
            out.append(residuals(data, k, rows, BEZIER[NUMBER[1.0, 0.0, SKIES[k][2]]])[0][::6])
        return np.nan_to_num(np.concatenate(out), nan=10, posinf=10, neginf=-10)

    found = least_squares(errors, start[1:] - start[0], x_scale="jac", max_nfev=60)
    return scaled(corners, np.concatenate([[0.0], found.x]))


def together(data: Data, corners: np.ndarray, steps: int = 4) -> np.ndarray:
    """Corners after Gauss–Newton steps on all skies."""
    for _ in range(steps):
        matrix, slope, worst = np.zeros((1200, 1200)), np.zeros(1200), 0.0
        for k, (turbidity, albedo, x) in enumerate(SKIES):
            mixed = mixture(turbidity, albedo)
            rows = sum(w * corners[t, a] for t, a, w in mixed)
            error, by = residuals(data, k, rows, BEZIER[NUMBER[1.0, 0.0, x]])
            worst = max(worst, float(np.abs(error).max()))
            square, down = by.T @ by, by.T @ error
            for t, a, w in mixed:
                here = slice(60 * (2 * t + a), 60 * (2 * t + a + 1))
                slope[here] += w * down
                for t2, a2, w2 in mixed:
                    matrix[here, 60 * (2 * t2 + a2) : 60 * (2 * t2 + a2 + 1)] += w * w2 * square
        print(f"  worst relative error {worst:.2g}", flush=True)
        size = np.sqrt(np.diag(matrix)) + 1e-30
        damped = matrix / np.outer(size, size) + 1e-10 * np.eye(1200)
        corners = corners + (np.linalg.solve(damped, -slope / size) / size).reshape(corners.shape)
    return corners


def main() -> None:
    """Measure, fit, write."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    directions, rgb = measured()
    channels = []
    np.seterr(all="ignore")
    for channel in range(3):
        print(f"channel {'XYZ'[channel]}")
        data = Data(directions, rgb, channel)
        channels.append(together(data, with_scales(data, corners_of(data))))
    target = folder / "hosek.npz" if len(sys.argv) > 1 else ROOT / "pt_engine" / "textures" / "hosek.npz"
    np.savez_compressed(target, control_points=np.stack(channels))


if __name__ == "__main__":
    main()
