"""Glass with Beckmann's distribution: see `dielectric`."""

from functools import partial

from . import dielectric
from .dielectric import Params, albedo
from .microfacet import Beckmann

SPECULAR = True
TRANSMITS = True

eval_pdf = partial(dielectric.eval_pdf, model=Beckmann)
sample = partial(dielectric.sample, model=Beckmann)

__all__ = ["Params", "albedo", "eval_pdf", "sample"]
