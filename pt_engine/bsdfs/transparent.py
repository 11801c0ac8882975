"""Straight through, unbent: f ∝ δ(wo + wi). Its colour is the closure's weight."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .base import BSDFSample, Float32, Lobe


class Params(NamedTuple):
    """None: the colour is the closure's weight."""


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """Zero: a given direction is never the one."""
    return np.zeros((1, wo.shape[1]), np.float32), np.zeros(wo.shape[1], np.float32)


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """wo = −wi, certainly."""
    n = wi.shape[1]
    lobe = Lobe.DELTA | Lobe.TRANSMIT | Lobe.TRANSPARENT
    return BSDFSample(-wi, np.ones(n, np.float32), np.ones((1, n), np.float32), lobe)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)
