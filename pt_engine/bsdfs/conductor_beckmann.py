"""Metal and gloss with Beckmann's distribution: see `conductor`."""

from functools import partial

from . import conductor
from .conductor import Params, albedo
from .microfacet import Beckmann

SPECULAR = True

eval_pdf = partial(conductor.eval_pdf, model=Beckmann)
sample = partial(conductor.sample, model=Beckmann)

__all__ = ["Params", "albedo", "eval_pdf", "sample"]
