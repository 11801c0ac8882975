"""Colours: Mix in all its types, HSV, Invert, Gamma, Bright/Contrast, Separate and Combine, Blackbody."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .color_spaces import SPACES, from_rgb, hsv_to_rgb, rgb_to_hsv, to_rgb
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, grey, op
from .math_nodes import divide, power, saturate, select
from .registry import Outputs, node
from .spectra import blackbody_rec709, wavelength_rec709
from .vector_nodes import separate, stack

Float32 = NDArray[np.float32]
Blend = Callable[[Float32, Float32, Float32], Float32]


def lerp(a: Float32, b: Float32, t: Float32) -> Float32:
    """a(1 − t) + b·t."""
    out: Float32 = a * (1 - t) + b * t
    return out


def toward(a: Float32, b: Float32, t: Float32) -> Float32:
    """a + t(b − a): what Cycles' blend modes have; beside a huge a it loses b's digits, as theirs does."""
    out: Float32 = a + t * (b - a)
    return out


# ------------------------------------------------------------------ blend modes, (t, a, b) → colour


def overlay(t: Float32, a: Float32, b: Float32) -> Float32:
    low = a * (1 - t + 2 * t * b)
    return select(a < 0.5, low, 1 - (1 - t + 2 * t * (1 - b)) * (1 - a))


def division(t: Float32, a: Float32, b: Float32) -> Float32:
    return select(b != 0, (1 - t) * a + t * divide(a, b), a)


def dodge(t: Float32, a: Float32, b: Float32) -> Float32:
    rest = 1 - t * b
    out = select(rest <= 0, np.float32(1), np.minimum(divide(a, rest), 1))
    return select(a != 0, out, a)


def burn(t: Float32, a: Float32, b: Float32) -> Float32:
    rest = 1 - t + t * b
    return select(rest <= 0, np.float32(0), np.clip(1 - divide(1 - a, rest), 0, 1))


def hue(t: Float32, a: Float32, b: Float32) -> Float32:
    x, y = np.broadcast_arrays(a, b)
    other = rgb_to_hsv(y)
    hsv = rgb_to_hsv(x)
    turned = hsv_to_rgb(np.stack([other[0], hsv[1], hsv[2]]))
    return select(other[1] != 0, toward(a, turned, t), a)


def saturation(t: Float32, a: Float32, b: Float32) -> Float32:
    x, y = np.broadcast_arrays(a, b)
    hsv, other = rgb_to_hsv(x), rgb_to_hsv(y)
    changed = hsv_to_rgb(stack(hsv[0], lerp(hsv[1], other[1], t), hsv[2]))
    return select(hsv[1] != 0, changed, a)


def brightness(t: Float32, a: Float32, b: Float32) -> Float32:
    x, y = np.broadcast_arrays(a, b)
    hsv = rgb_to_hsv(x)
    return hsv_to_rgb(stack(hsv[0], hsv[1], lerp(hsv[2], rgb_to_hsv(y)[2], t)))


def tone(t: Float32, a: Float32, b: Float32) -> Float32:
    x, y = np.broadcast_arrays(a, b)
    other = rgb_to_hsv(y)
    changed = hsv_to_rgb(np.stack([other[0], other[1], rgb_to_hsv(x)[2]]))
    return select(other[1] != 0, toward(a, changed, t), a)


def soft_light(t: Float32, a: Float32, b: Float32) -> Float32:
    screen = 1 - (1 - b) * (1 - a)
    out: Float32 = (1 - t) * a + t * ((1 - a) * b * a + a * screen)
    return out


BLENDS: dict[str, Blend] = {
    "MIX": lambda t, a, b: toward(a, b, t),
    "DARKEN": lambda t, a, b: toward(a, np.minimum(a, b), t),
    "MULTIPLY": lambda t, a, b: a * (1 - t + t * b),
    "BURN": burn,
    "LIGHTEN": lambda t, a, b: toward(a, np.maximum(a, b), t),
    "SCREEN": lambda t, a, b: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "DODGE": dodge,
    "ADD": lambda t, a, b: a + t * b,
    "OVERLAY": overlay,
    "SOFT_LIGHT": soft_light,
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2 * b - 1),
    "DIFFERENCE": lambda t, a, b: toward(a, np.abs(a - b), t),
    "EXCLUSION": lambda t, a, b: np.maximum(toward(a, a + b - 2 * a * b, t), 0),
    "SUBTRACT": lambda t, a, b: a - t * b,
    "DIVIDE": division,
    "HUE": hue,
    "SATURATION": saturation,
    "COLOR": tone,
    "VALUE": brightness,
}


@op(COLOR)
def mix_color(mode: str, t: Float32, a: Float32, b: Float32) -> Float32:
    """A blend mode of the Mix node."""
    return BLENDS[mode](t, a, b)


@op(FLOAT)
def mix_float(t: Float32, a: Float32, b: Float32) -> Float32:
    """a(1 − t) + b·t."""
    return lerp(a, b, t)


@op(VECTOR)
def mix_vector(t: Float32, a: Float32, b: Float32) -> Float32:
    """a(1 − t) + b·t, with one t or one per component."""
    return lerp(a, b, t)


@op(COLOR)
def saturate_color(c: Float32) -> Float32:
    """Clamped to [0, 1]."""
    return np.minimum(np.maximum(c, 0), 1)


@op(VECTOR)
def saturate_vector(c: Float32) -> Float32:
    """Clamped to [0, 1]."""
    return np.minimum(np.maximum(c, 0), 1)


def factor(n: NodeView, name: str, clamp: bool) -> Value:
    """A mix factor; clamped where the node says so."""
    t = n.float(name, 0.5)
    return n.call(saturate, t) if clamp else t


def one_side(t: Value) -> int:
    """0 or 1 where the factor is constantly that, else −1."""
    from .ir import Const

    if isinstance(t, Const) and t.is_all(0):
        return 0
    return 1 if isinstance(t, Const) and t.is_all(1) else -1


@node("Mix")
def mix_node(n: NodeView) -> Outputs:
    kind, clamp = n.prop("data_type", "FLOAT"), bool(n.prop("clamp_factor", True))
    if kind == "ROTATION":
        n.ignored("rotations are not mixed")
        return {}
    if kind == "VECTOR" and n.prop("factor_mode", "UNIFORM") == "NON_UNIFORM":
        t = n.vector("Factor_Vector", 0.5)
        t = n.call(saturate_vector, t) if clamp else t
        return {"Result_Vector": n.call(mix_vector, t, n.vector("A_Vector"), n.vector("B_Vector"))}
    t = factor(n, "Factor_Float", clamp)
    side = one_side(t)
    if kind == "FLOAT":
        if side >= 0:
            return {"Result_Float": n.float("AB"[side] + "_Float")}
        return {"Result_Float": n.call(mix_float, t, n.float("A_Float"), n.float("B_Float"))}
    if kind == "VECTOR":
        if side >= 0:
            return {"Result_Vector": n.vector("AB"[side] + "_Vector")}
        return {"Result_Vector": n.call(mix_vector, t, n.vector("A_Vector"), n.vector("B_Vector"))}
    mode = str(n.prop("blend_type", "MIX"))
    out = blended(n, mode, t, ("A_Color", "B_Color"))
    return {"Result_Color": n.call(saturate_color, out) if n.prop("clamp_result", False) else out}


CLAMPING = ("LIGHTEN", "DODGE", "BURN")  # blends that change their first colour even with the factor 0


def blended(n: NodeView, mode: str, t: Value, names: tuple[str, str]) -> Value:
    """Two colour inputs blended; what a constant factor hides is not even compiled."""
    side = one_side(t)
    if mode not in BLENDS:
        n.ignored(f"blend mode {mode} is not understood: the first colour")
        return n.color(names[0], 0.5)
    if (side == 0 and mode not in CLAMPING) or (side == 1 and mode == "MIX"):
        return n.color(names[side], 0.5)
    return n.call(mix_color, t, n.color(names[0], 0.5), n.color(names[1], 0.5), static=(mode,))


@node("MixRGB")
def mix_rgb_node(n: NodeView) -> Outputs:
    t = factor(n, "Fac", True)
    out = blended(n, str(n.prop("blend_type", "MIX")), t, ("Color1", "Color2"))
    return {"Color": n.call(saturate_color, out) if n.prop("use_clamp", False) else out}


# ------------------------------------------------------------------ adjustments


@op(COLOR)
def hue_saturation(t: Float32, color: Float32, h: Float32, s: Float32, v: Float32) -> Float32:
    """Hue/Saturation/Value: hue turned by h − ½, saturation times s, value times v."""
    hsv = rgb_to_hsv(color)
    turned = hsv[0] + h + np.float32(0.5)
    changed = hsv_to_rgb(stack(turned - np.floor(turned), np.clip(hsv[1] * s, 0, 1), hsv[2] * v))
    return np.maximum(lerp(color, changed, t), 0)


@node("HueSaturation")
def hue_saturation_node(n: NodeView) -> Outputs:
    color = n.color("Color", 0.8)
    t = n.float("Fac", 1.0)
    hsv = n.float("Hue", 0.5), n.float("Saturation", 1.0), n.float("Value", 1.0)
    return {"Color": n.call(hue_saturation, t, color, *hsv)}


@op(COLOR)
def invert(t: Float32, color: Float32) -> Float32:
    """t(1 − c) + (1 − t)c."""
    return lerp(color, 1 - color, t)


@node("Invert")
def invert_node(n: NodeView) -> Outputs:
    return {"Color": n.call(invert, n.float("Fac", 1.0), n.color("Color"))}


@op(COLOR)
def gamma(color: Float32, exponent: Float32) -> Float32:
    """c^γ where c is positive; 1 for γ = 0."""
    positive = color > 0
    raised = select(positive, power(select(positive, color, 1), exponent), color)
    return select(exponent == 0, np.float32(1), raised)


@node("Gamma")
def gamma_node(n: NodeView) -> Outputs:
    return {"Color": n.call(gamma, n.color("Color", 1.0), n.float("Gamma", 1.0))}


@op(COLOR)
def bright_contrast(color: Float32, bright: Float32, contrast: Float32) -> Float32:
    """max((1 + contrast)c + bright − contrast/2, 0)."""
    out: Float32 = np.maximum((1 + contrast) * color + (bright - contrast * np.float32(0.5)), 0)
    return out


@node("BrightContrast")
def bright_contrast_node(n: NodeView) -> Outputs:
    return {"Color": n.call(bright_contrast, n.color("Color", 1.0), n.float("Bright"), n.float("Contrast"))}


@op(FLOAT)
def folded_grey(c: Float32) -> Float32:
    """Luminance by the shorter digits that Blender has where it folds."""
    y: Float32 = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
    return y


@node("RGBToBW")
def rgb_to_bw(n: NodeView) -> Outputs:
    return {"Val": n.call(folded_grey if n.prop("folded", False) else grey, n.color("Color", 0.5))}


# ------------------------------------------------------------------ separate, combine


@op(COLOR)
def separated_space(space: str, rgb: Float32) -> Float32:
    """RGB to another colour model."""
    return from_rgb(space, rgb)


@op(COLOR)
def combined_space(space: str, x: Float32, y: Float32, z: Float32) -> Float32:
    """A colour from its components in a model."""
    return to_rgb(space, stack(x, y, z))


def components(n: NodeView, space: str, color: Value) -> tuple[Value, ...]:
    if space != "RGB":
        color = n.call(separated_space, color, static=(space,))
    return n.calls(separate, color)


@node("SeparateColor")
def separate_color(n: NodeView) -> Outputs:
    mode = str(n.prop("mode", "RGB"))
    space = mode if mode in SPACES else "RGB"
    return dict(zip(("Red", "Green", "Blue"), components(n, space, n.color("Color", 0.8)), strict=True))


@node("CombineColor")
def combine_color(n: NodeView) -> Outputs:
    mode = str(n.prop("mode", "RGB"))
    static = (mode if mode in SPACES else "RGB",)
    return {"Color": n.call(combined_space, *(n.float(c) for c in ("Red", "Green", "Blue")), static=static)}


@node("SeparateRGB")
def separate_rgb(n: NodeView) -> Outputs:
    return dict(zip("RGB", components(n, "RGB", n.color("Image", 0.8)), strict=True))


@node("SeparateHSV")
def separate_hsv(n: NodeView) -> Outputs:
    return dict(zip("HSV", components(n, "HSV", n.color("Color", 0.8)), strict=True))


@node("CombineRGB")
def combine_rgb(n: NodeView) -> Outputs:
    return {"Image": n.call(combined_space, *(n.float(c) for c in "RGB"), static=("RGB",))}


@node("CombineHSV")
def combine_hsv(n: NodeView) -> Outputs:
    return {"Color": n.call(combined_space, *(n.float(c) for c in "HSV"), static=("HSV",))}


# ------------------------------------------------------------------ spectra


@op(COLOR)
def blackbody(folded: bool, temperature: Float32) -> Float32:
    """Colour of a black body, luminance 1."""
    return np.maximum(blackbody_rec709(temperature, folded), 0)


@node("Blackbody")
def blackbody_node(n: NodeView) -> Outputs:
    folded = bool(n.prop("folded", False))
    return {"Color": n.call(blackbody, n.float("Temperature", 6500.0), static=(folded,))}


@op(COLOR)
def wavelength(nanometres: Float32) -> Float32:
    """Colour of a single wavelength."""
    return wavelength_rec709(nanometres)


@node("Wavelength")
def wavelength_node(n: NodeView) -> Outputs:
    return {"Color": n.call(wavelength, n.float("Wavelength", 500.0))}
