"""Refraction alone with Beckmann's distribution: see `refraction`."""

from functools import partial

from . import refraction
from .microfacet import Beckmann
from .refraction import Params, albedo

SPECULAR = True
TRANSMITS = True

eval_pdf = partial(refraction.eval_pdf, model=Beckmann)
sample = partial(refraction.sample, model=Beckmann)

__all__ = ["Params", "albedo", "eval_pdf", "sample"]
