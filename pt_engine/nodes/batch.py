"""A batch: the materials that share a program, shaded together."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .gates import GatedEntry
from .ir import COLOR, Value
from .program import ConstantTable, Entry, LanesLike, Structure, linearise
from .surface import SurfaceBuilder

Float32 = NDArray[np.float32]


class Closure(NamedTuple):
    """A scattering model at work: its module (see `bsdfs.base`), parameters and weight.

    `normal` (3, n) None means `lanes.ns`; `tangent` (3, n) None any frame; `base` (3, n) is the surface's
    own normal where displacement bends it.
    """

    bsdf: ModuleType
    params: Any
    weight: Float32
    normal: Float32 | None
    tangent: Float32 | None
    base: Float32 | None = None


class Shape(NamedTuple):
    """How a closure's values lie among the program's roots (−1: absent)."""

    bsdf: str
    params: tuple[tuple[str, int], ...]
    weight: int
    normal: int
    tangent: int
    dirac: bool


class Plan(NamedTuple):
    """A program's structure with the meaning of its roots: equal for materials that share a batch."""

    structure: Structure
    closures: tuple[Shape, ...]
    base: int
    emission: int
    transparency: int
    holdout: int


def plan(surface: SurfaceBuilder) -> tuple[Plan, list[Float32]]:
    """A material's plan, and the values of its constants."""
    roots, shapes, base, others = roots_of(surface)
    structure, constants = linearise(roots)
    return Plan(structure, shapes, base, *others), constants


def roots_of(
    surface: SurfaceBuilder,
) -> tuple[list[Value], tuple[Shape, ...], int, tuple[int, int, int]]:
    """All values that a surface needs, and where in them its parts are.

    Returns
    -------
    roots : list of Value
    shapes : tuple of Shape
    base : int
    others : emission, transparency and holdout; of the latter two −1 for none.
    """
    roots: list[Value] = []

    def root(value: Value | None) -> int:
        if value is None:
            return -1
        roots.append(value)
        return len(roots) - 1

    shapes = tuple(
        Shape(
            leaf.bsdf,
            tuple((name, root(p)) for name, p in leaf.params),
            root(leaf.weight),
            root(leaf.normal),
            root(leaf.tangent),
            leaf.dirac,
        )
        for leaf in surface.leaves
    )
    base = root(surface.base)
    # no emission is a constant like any other: lamps share a batch with what else scatters as they do
    emission = surface.builder.constant(0.0, COLOR) if surface.emission is None else surface.emission
    others = root(emission), root(surface.transparency), root(surface.holdout)
    return roots, shapes, base, others


def model(name: str) -> ModuleType:
    """A scattering model's module by its name in `bsdfs`."""
    package = (__package__ or "pt_engine.nodes").rpartition(".")[0]
    return importlib.import_module(f"{package}.bsdfs.{name}")


def weights_of(plan: Plan, count: int) -> list[int]:
    """For each of the first roots the one that is its closure's weight; −1 for those with none above them."""
    weights = [-1] * count
    for shape in plan.closures:
        for root in (*(k for _, k in shape.params), shape.normal, shape.tangent):
            if root >= 0:
                weights[root] = shape.weight
    return weights


class Batch:
    """Shades lanes of the materials that share a program.

    Attributes
    ----------
    materials : tuple of int
        Their indices in `Snapshot.materials`.
    has_bsdf, has_emission, has_transparency, has_holdout : bool
    has_portal : bool
        Whether some closure makes rays leave elsewhere.
    transmits : bool
        Whether light that comes from behind is scattered to the front.
    delta_only : bool
        Whether no closure is anything but a Dirac lobe (emitter sampling is then futile).
    kinds : tuple of str
        Names of the scattering models.
    closure_entry, emission_entry, transparency_entry, holdout_entry : Entry
        The ways into the program; all but the first None where there is nothing to compute.
    needs : frozenset of str
        Lane attributes the program reads: ``uv:NAME``, ``color:NAME``, ``tangent:NAME``, ``generated`` ...
    """

    def __init__(self, plan: Plan, constants: Sequence[Sequence[Float32]], materials: Sequence[int]) -> None:
        self.plan, self.materials = plan, tuple(materials)
        self.table = ConstantTable(constants, materials)
        self._shapes = plan.closures
        self._modules = [model(s.bsdf) for s in plan.closures]
        others = plan.emission, plan.transparency, plan.holdout
        count = len(plan.structure.roots) - sum(root >= 0 for root in others)
        self.closure_entry = GatedEntry(plan.structure, self.table, range(count), weights_of(plan, count))
        self.emission_entry = self._entry(plan.emission)
        known = self.constant_emission()
        if known is not None and not known.any():
            self.emission_entry = None
        self.transparency_entry = self._entry(plan.transparency)
        self.holdout_entry = self._entry(plan.holdout)
        self.has_bsdf = bool(plan.closures)
        self.has_emission = self.emission_entry is not None
        self.has_transparency, self.has_holdout = plan.transparency >= 0, plan.holdout >= 0
        self.delta_only = self.has_bsdf and all(s.dirac for s in plan.closures)
        self.has_portal = any(getattr(module, "LEADS_AWAY", False) for module in self._modules)
        self.transmits = any(getattr(module, "TRANSMITS", False) for module in self._modules)
        self._bends = any(s.normal >= 0 for s in plan.closures)
        self.kinds = tuple(s.bsdf for s in plan.closures)
        entries = [self.closure_entry, self.emission_entry, self.transparency_entry, self.holdout_entry]
        self.needs = frozenset(name for e in entries if e is not None for name in e.reads())
        self._params = self._fixed_params()
        self._made = self._fixed_closures()

    def _entry(self, root: int) -> Entry | None:
        return Entry(self.plan.structure, self.table, [root]) if root >= 0 else None

    def _fixed_params(self) -> list[Any]:
        """Parameters that no lane can change, built now; None for the others."""
        made: list[Any] = []
        for shape, module in zip(self._shapes, self._modules, strict=True):
            known = {name: self.closure_entry.constant(k) for name, k in shape.params}
            fixed = all(value is not None for value in known.values())
            made.append(params_of(module, known) if fixed else None)
        return made

    def _fixed_closures(self) -> list[Closure] | None:
        """All closures, where no lane can change any."""
        if not self.closure_entry.is_constant:
            return None
        values = [self.closure_entry.constant(k) for k in range(len(self.closure_entry.outputs))]
        return [self._closure(k, values, None) for k in range(len(self._shapes))]

    def _closure(self, number: int, values: Sequence[Float32 | None], ns: Float32 | None) -> Closure:
        shape, module, params = self._shapes[number], self._modules[number], self._params[number]
        if params is None:
            params = params_of(module, {name: values[k] for name, k in shape.params})
        normal = values[shape.normal] if shape.normal >= 0 else None
        tangent = values[shape.tangent] if shape.tangent >= 0 else None
        weight = values[shape.weight]
        if weight is None:
            raise RuntimeError(f"{shape.bsdf} has no weight")
        base = values[self.plan.base] if self.plan.base >= 0 else None
        return Closure(module, params, weight, None if normal is ns else normal, tangent, base)

    def closures(self, lanes: LanesLike) -> list[Closure]:
        """What the lanes' surfaces scatter."""
        if self._made is not None:
            return self._made
        with np.errstate(all="ignore"):
            values = self.closure_entry.run(lanes)
        ns = lanes.ns if self._bends else None
        return [self._closure(k, values, ns) for k in range(len(self._shapes))]

    def emission(self, lanes: LanesLike) -> Float32 | None:
        """(3, n) or (3, 1) radiance emitted toward `lanes.wi`; None where the materials emit nothing."""
        return _single(self.emission_entry, lanes)

    def transparency(self, lanes: LanesLike) -> Float32 | None:
        """(3, n) or (3, 1) share of light that passes straight through; None for opaque materials."""
        return _single(self.transparency_entry, lanes)

    def holdout(self, lanes: LanesLike) -> Float32 | None:
        """(3, n) or (3, 1) share of what the camera sees that is a hole in the film; None for no holdout."""
        return _single(self.holdout_entry, lanes)

    def constant_emission(self) -> Float32 | None:
        """(3, M) exact radiance of each of `materials`, or None where it varies over the surface."""
        if self.emission_entry is None:
            return np.zeros((3, len(self.materials)), np.float32)
        slot = self.emission_entry.outputs[0]
        if not slot.constant:
            return None
        fixed = self.table.fixed[slot.number]
        if fixed is None:
            return self.table.varying[self.table.column[slot.number]]
        return np.repeat(fixed, len(self.materials), axis=1)


def params_of(module: ModuleType, known: dict[str, Float32 | None]) -> Any:
    """A model's parameters; those that a closure does not name and that have no default are None."""
    absent = set(module.Params._fields) - set(module.Params._field_defaults) - set(known)
    return module.Params(**known, **dict.fromkeys(absent))


def _single(entry: Entry | None, lanes: LanesLike) -> Float32 | None:
    if entry is None:
        return None
    with np.errstate(all="ignore"):
        value: Float32 = entry.run(lanes)[0]
    return value
