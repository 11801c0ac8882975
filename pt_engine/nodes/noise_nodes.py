"""The Noise and Wave textures."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from . import noise
from .coordinates import coordinates
from .graph import NodeView
from .ir import COLOR, FLOAT, Op, Value, op, spread_color
from .perlin import signed_noise
from .registry import Outputs, node

Float32 = NDArray[np.float32]
FEW: Final = 4096  # lanes
TWO_PI: Final = np.float32(2 * np.pi)


def point_of(dimensions: int, vector: Float32, w: Float32, scale: Float32) -> list[Float32]:
    """The scaled coordinates that a texture of so many dimensions uses."""
    if dimensions == 1:
        return [w * scale]
    axes = [vector[k] * scale for k in range(min(dimensions, 3))]
    return [*axes, w * scale] if dimensions == 4 else axes


def distorted(point: list[Float32], amount: Float32) -> list[Float32]:
    """The point moved by noise, one offset per axis."""
    if not (amount != 0).any():
        return point
    wobble = [signed_noise(noise.moved(point, float(k))) for k in range(len(point))]
    # rounded once, as the fused multiply-add in Cycles is: far from the origin a last bit shows
    return [
        (p + w.astype(np.float64) * amount).astype(np.float32) for p, w in zip(point, wobble, strict=True)
    ]


def _settings(detail: Float32, roughness: Float32, *rest: Float32) -> tuple[Float32, ...]:
    return np.clip(detail, 0, 15), np.maximum(roughness, 0), *rest


SETTINGS: Final = ("detail", "roughness", "lacunarity", "offset", "gain")


@cache
def noise_channels(channels: tuple[int, ...]) -> Op:
    """The Noise texture's Color: its Factor in red, two more of its kind in green and blue; others are 0."""

    def noise_color(
        dimensions: int,
        kind: str,
        normalize: bool,
        vector: Float32,
        w: Float32,
        scale: Float32,
        distortion: Float32,
        *settings: Float32,
    ) -> Float32:
        point = distorted(point_of(dimensions, vector, w, scale), distortion)
        fractal, values = noise.FRACTALS[kind], _settings(*settings)
        points = [noise.moved(point, float(dimensions + k - 1)) if k else point for k in channels]
        size = max(a.shape[-1] for a in (*point, *values))
        color = np.zeros((3, size), np.float32)
        if size > FEW:
            for k, p in zip(channels, points, strict=True):
                color[k] = fractal(p, values, normalize)
            return color
        # few lanes: all channels at once, because what numpy's calls cost by themselves counts then
        wide = [
            np.concatenate([np.broadcast_to(p, size) for p in axis]) for axis in zip(*points, strict=True)
        ]
        repeated = [v if v.shape[-1] == 1 else np.tile(np.broadcast_to(v, size), len(points)) for v in values]
        color[list(channels)] = fractal(wide, repeated, normalize).reshape(-1, size)
        return color

    noise_color.__name__ = "noise_" + ("color" if len(channels) == 3 else "".join("rgb"[k] for k in channels))
    return Op(noise_color, (COLOR,), rest=SETTINGS, part=noise_channels, dear=True)


noise_color: Final = noise_channels((0, 1, 2))


def _noise_value(
    dimensions: int,
    kind: str,
    normalize: bool,
    vector: Float32,
    w: Float32,
    scale: Float32,
    distortion: Float32,
    *settings: Float32,
) -> Float32:
    """The Noise texture's Factor."""
    point = distorted(point_of(dimensions, vector, w, scale), distortion)
    return noise.FRACTALS[kind](point, _settings(*settings), normalize)


noise_value: Final = Op(_noise_value, (FLOAT,), first_of=noise_color, rest=SETTINGS, dear=True)


@node("TexNoise")
def tex_noise(n: NodeView) -> Outputs:
    dimensions = int(str(n.prop("noise_dimensions", "3D"))[0])
    kind = str(n.prop("noise_type", "FBM"))
    if kind not in noise.FRACTALS:
        n.approximate(f"noise type {kind} is not understood: FBM")
        kind = "FBM"
    vector = coordinates(n)
    names = (("Detail", 2.0), ("Roughness", 0.5), ("Lacunarity", 2.0), ("Offset", 0.0), ("Gain", 1.0))
    inputs = [
        vector,
        n.float("W"),
        n.float("Scale", 5.0),
        n.float("Distortion"),
        *(n.float(name, default) for name, default in names),
    ]
    static = (dimensions, kind, bool(n.prop("normalize", True)))
    out: dict[str, Value | None] = {}
    if n.wants("Color"):
        out["Color"] = n.call(noise_color, *inputs, static=static)
    if n.wants("Fac"):
        out["Fac"] = n.call(noise_value, *inputs, static=static)
    return out


# ------------------------------------------------------------------ Wave


def _phase(kind: str, direction: str, p: Float32) -> Float32:
    """20 times the distance along the bands or from the rings' axis."""
    x, y, z = p
    if kind == "BANDS":
        bands: dict[str, Float32] = {"X": x * 20, "Y": y * 20, "Z": z * 20}
        diagonal: Float32 = (x + y + z) * 10
        return bands.get(direction, diagonal)
    squares = [c * c for c, axis in zip((x, y, z), "XYZ", strict=True) if axis != direction]
    total: Float32 = squares[0] + squares[1]
    if len(squares) == 3:
        total = total + squares[2]
    return np.sqrt(total) * np.float32(20)


@op(FLOAT, dear=True)
def wave(
    kind: str,
    direction: str,
    profile: str,
    vector: Float32,
    scale: Float32,
    distortion: Float32,
    detail: Float32,
    detail_scale: Float32,
    roughness: Float32,
    phase: Float32,
) -> Float32:
    """The Wave texture's value in [0, 1]."""
    p = (vector * scale + np.float32(1e-6)) * np.float32(0.999999)
    n = _phase(kind, direction, p) + phase
    if (distortion != 0).any():
        point = [c * detail_scale for c in p]
        wobble = noise.fbm(point, detail, roughness, np.full(1, 2, np.float32), True) * 2 - 1
        n = n + distortion * wobble
    if profile == "SIN":
        return np.float32(0.5) + np.float32(0.5) * np.sin(n - np.float32(np.pi / 2))
    turns = n / TWO_PI
    if profile == "SAW":
        return turns - np.floor(turns)
    return np.abs(turns - np.floor(turns + np.float32(0.5))) * 2


@node("TexWave")
def tex_wave(n: NodeView) -> Outputs:
    kind = str(n.prop("wave_type", "BANDS"))
    direction = str(n.prop("bands_direction" if kind == "BANDS" else "rings_direction", "X"))
    inputs = [
        coordinates(n),
        n.float("Scale", 5.0),
        n.float("Distortion"),
        n.float("Detail", 2.0),
        n.float("Detail Scale", 1.0),
        n.float("Detail Roughness", 0.5),
        n.float("Phase Offset"),
    ]
    f = n.call(wave, *inputs, static=(kind, direction, str(n.prop("wave_profile", "SIN"))))
    return {"Fac": f, "Color": n.call(spread_color, f)}
