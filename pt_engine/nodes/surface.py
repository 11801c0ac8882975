"""What a shader graph's Surface comes down to: weighted scattering models, emission, transparency."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .ir import COLOR, Builder, Const, Op, Value

TRANSPARENT = "transparent"


@dataclass(frozen=True)
class Leaf:
    """One closure: a scattering model (a module of `bsdfs`), its parameters by name, its weight.

    `normal` None means the shading normal; `tangent` None any frame; `dirac` that it is nothing but a
    Dirac lobe.
    """

    bsdf: str
    params: tuple[tuple[str, Value], ...]
    weight: Value
    normal: Value | None = None
    tangent: Value | None = None
    dirac: bool = False


@dataclass
class SurfaceBuilder:
    """Collects closures; those whose weight is constantly zero are never added."""

    builder: Builder
    leaves: list[Leaf] = field(default_factory=list)
    emission: Value | None = None
    transparency: Value | None = None
    holdout: Value | None = None
    base: Value | None = None  # the surface's normal where displacement bends it

    def add(
        self,
        bsdf: str,
        params: Mapping[str, Value],
        weight: Value,
        normal: Value | None = None,
        tangent: Value | None = None,
        dirac: bool = False,
    ) -> None:
        """A scattering closure; negative weights count as 0, as in Cycles. Equal ones are added up."""
        weight = self.positive(weight)
        if is_zero(weight):
            return
        new = Leaf(bsdf, tuple(params.items()), weight, normal, tangent, dirac)
        for k, leaf in enumerate(self.leaves):
            if replace(leaf, weight=weight) == new:
                self.leaves[k] = replace(new, weight=self.builder.add(leaf.weight, weight))
                return
        self.leaves.append(new)

    def add_transparent(self, weight: Value) -> None:
        """A closure that lets rays pass unbent; shadow rays see the sum of these."""
        weight = self.positive(weight)
        if is_zero(weight):
            return
        self.leaves.append(Leaf(TRANSPARENT, (), weight, dirac=True))
        old = self.transparency
        self.transparency = weight if old is None else self.builder.add(old, weight)

    def add_emission(self, radiance: Value) -> None:
        """Emitted radiance, W·m⁻²·sr⁻¹."""
        radiance = self.builder.convert(radiance, COLOR)
        if is_zero(radiance):
            return
        self.emission = radiance if self.emission is None else self.builder.add(self.emission, radiance)

    def add_holdout(self, weight: Value) -> None:
        """A share of what the camera sees that becomes a hole in the film."""
        weight = self.positive(weight)
        if not is_zero(weight):
            self.holdout = weight if self.holdout is None else self.builder.add(self.holdout, weight)

    def positive(self, weight: Value) -> Value:
        """max(weight, 0) as a colour."""
        weight = self.builder.convert(weight, COLOR)
        if isinstance(weight, Const) and (weight.data >= 0).all():
            return weight
        return self.builder.call(at_least_zero, weight)[0]

    def only_one_transparent(self) -> None:
        """Merge the transparent closures: one straight line through is enough."""
        clear = [leaf for leaf in self.leaves if leaf.bsdf == TRANSPARENT]
        if len(clear) > 1 and self.transparency is not None:
            self.leaves = [leaf for leaf in self.leaves if leaf.bsdf != TRANSPARENT]
            self.leaves.append(Leaf(TRANSPARENT, (), self.transparency, dirac=True))


def is_constantly(value: Value, number: float) -> bool:
    """Whether a value is a constant of which all components equal `number`."""
    return isinstance(value, Const) and value.is_all(number)


def is_zero(value: Value) -> bool:
    """Whether a value is the constant 0."""
    return is_constantly(value, 0)


def is_at_most(value: Value, number: float) -> bool:
    """Whether a value is a constant of which no component is above `number`."""
    return isinstance(value, Const) and bool((value.data <= number).all())


def _at_least_zero(c: NDArray[np.float32]) -> NDArray[np.float32]:
    """max(c, 0)."""
    return np.maximum(c, 0)


at_least_zero = Op(_at_least_zero, (COLOR,), keeps_zero=True)
