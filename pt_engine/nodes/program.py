"""A compiled program: a straight list of steps over numbered slots, and the table of its constants.

Programs have the same `Structure` where only constants differ; their materials share a `Batch`. Of its
constants those that are equal in all its materials are broadcast; the rest are rows of a table that
lanes gather from by their material.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .ir import Call, Const, Op, Result, Static, Value, as_float, first_component, shift_of

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class LanesLike(Protocol):
    """What programs themselves need of lanes; ops read more (see `scene.lanes`)."""

    @property
    def n(self) -> int: ...
    @property
    def material(self) -> Int32: ...
    @property
    def ns(self) -> Float32: ...


class Slot(NamedTuple):
    """Where a value is: constant number `number`, or (`constant` False) the result of that number."""

    constant: bool
    number: int
    type: str


class Step(NamedTuple):
    """One call: results `first`, `first + 1` ... of `op` applied to `args`."""

    op: Op
    static: Static
    shift: int
    args: tuple[Slot, ...]
    first: int


class Structure(NamedTuple):
    """A program without its constants' values: hashable, equal for materials that can share a batch."""

    steps: tuple[Step, ...]
    roots: tuple[Slot, ...]


def linearise(roots: Sequence[Value]) -> tuple[Structure, list[Float32]]:
    """Steps in an order in which they can run, and the constants, one per *use*.

    A constant gets a number per use, not per value: two materials have the same structure even where
    one of them happens to use the same number twice.
    """
    steps: list[Step] = []
    constants: list[Float32] = []
    first: dict[int, int] = {}
    results = 0

    def slot(value: Value) -> Slot:
        if isinstance(value, Const):
            constants.append(value.data)
            return Slot(True, len(constants) - 1, value.type)
        if not isinstance(value, Result):
            raise TypeError(f"not a value of a program: {value!r}")
        return Slot(False, first[id(value.call)] + value.index, value.type)

    for call in ordered_calls(roots):
        args = tuple(slot(a) for a in call.args)
        first[id(call)] = results
        steps.append(Step(call.op, call.static, call.shift, args, results))
        results += len(call.op.types)
    return Structure(tuple(steps), tuple(slot(r) for r in roots)), constants


def ordered_calls(roots: Iterable[Value]) -> list[Call]:
    """Every call that `roots` depend on, arguments before users (without recursion: chains may be long)."""
    done: set[int] = set()
    order: list[Call] = []
    stack = [(r.call, False) for r in reversed(list(roots)) if isinstance(r, Result)]
    while stack:
        call, ready = stack.pop()
        if id(call) in done:
            continue
        if ready:
            done.add(id(call))
            order.append(call)
            continue
        stack.append((call, True))
        stack.extend((a.call, False) for a in reversed(call.args) if isinstance(a, Result))
    return order


class ConstantTable:
    """The constants of a batch: `fixed[k]` for number k, or a column of `varying` by material.

    Parameters
    ----------
    constants : list of list of (1,) or (3, 1) float32
        Per material of the batch.
    materials : sequence of int
        Their numbers in the scene.
    """

    def __init__(self, constants: Sequence[Sequence[Float32]], materials: Sequence[int]) -> None:
        self.fixed: list[Float32 | None] = []
        self.column: list[int] = []
        self.varying: list[Float32] = []
        known: dict[bytes, int] = {}
        for values in zip(*constants, strict=True):
            if all(np.array_equal(values[0], v) for v in values[1:]):
                self.fixed.append(values[0])
                self.column.append(-1)
                continue
            column = np.ascontiguousarray(np.concatenate(values, axis=-1))
            key = column.tobytes()
            if key not in known:
                known[key] = len(self.varying)
                self.varying.append(column)
            self.fixed.append(None)
            self.column.append(known[key])
        self._row = np.zeros(max(materials, default=0) + 1, np.intp)  # as look-ups take them
        self._row[list(materials)] = np.arange(len(materials))

    def identity(self, slot: Slot) -> tuple[Any, ...]:
        """The same for slots that always hold the same value."""
        fixed = self.fixed[slot.number] if slot.constant else None
        if fixed is not None:
            return slot.type, fixed.tobytes()
        return slot.constant, self.column[slot.number] if slot.constant else slot.number

    def rows(self, lanes: LanesLike) -> NDArray[np.intp]:
        """(n,) row of the table for each lane."""
        return self._row.take(lanes.material, mode="clip")


class Entry:
    """One way into a program: computes some of its roots, doing only the work they need."""

    def __init__(self, structure: Structure, table: ConstantTable, roots: Sequence[int]) -> None:
        self.table = table
        self.outputs = [structure.roots[r] for r in roots]
        needed = components_taken(needed_steps(structure.steps, self.outputs), table)
        size = sum(len(s.op.types) for s in structure.steps)
        self.steps = components_read(taken_together(needed, table, size), self.outputs)
        self._dead = dead_after(self.steps, self.outputs)
        self._size = max([size, *(s.first + len(s.op.types) for s in self.steps)])
        used = {s.number for step in self.steps for s in step.args if s.constant}
        used |= {s.number for s in self.outputs if s.constant}
        self._constants: list[Any] = [None] * len(table.fixed)
        self._gathers: list[tuple[int, Float32]] = []
        for k in sorted(used):
            self._constants[k] = table.fixed[k]
            if table.fixed[k] is None:
                self._gathers.append((k, table.varying[table.column[k]]))
        self.is_constant = not self.steps and not self._gathers

    def with_steps(self, steps: Sequence[Step]) -> Entry:
        """The same with other steps of the same shape, for measurements."""
        other = copy.copy(self)
        other.steps = list(steps)
        return other

    def run(self, lanes: LanesLike) -> list[Float32]:
        """The roots' values."""
        constants = self._constants
        if self._gathers:
            constants = self._gathered(lanes)
        results: list[Any] = [None] * self._size
        shifts: dict[int, Any] = {0: lanes}
        for (what, static, shift, args, first), dead in zip(self.steps, self._dead, strict=True):
            arrays = [constants[s.number] if s.constant else results[s.number] for s in args]
            if what.lanes:
                if shift not in shifts:
                    shifts[shift] = lanes.shifted(*shift_of(shift))  # type: ignore[attr-defined]
                out = what.function(shifts[shift], *static, *arrays)
            else:
                out = what.function(*static, *arrays)
            if len(what.types) == 1:
                results[first] = out
            else:
                results[first : first + len(what.types)] = out
            del arrays, out
            for k in dead:
                results[k] = None
        return [constants[s.number] if s.constant else results[s.number] for s in self.outputs]

    def _gathered(self, lanes: LanesLike) -> list[Any]:
        rows = self.table.rows(lanes)
        constants = self._constants.copy()
        taken: dict[int, Float32] = {}
        for k, column in self._gathers:
            if id(column) not in taken:
                taken[id(column)] = column.take(rows, axis=-1, mode="clip")
            constants[k] = taken[id(column)]
        return constants

    def constant(self, output: int) -> Float32 | None:
        """The value of an output that no lane can change."""
        slot = self.outputs[output]
        return self._constants[slot.number] if slot.constant else None

    def reads(self) -> set[str]:
        """Names of the lane attributes that the steps need."""
        return {name for s in self.steps for name in s.op.reads(*s.static)}


def needed_steps(steps: Sequence[Step], outputs: Iterable[Slot]) -> list[Step]:
    """Those steps, in order, that `outputs` depend on, for no more results than are wanted."""
    wanted = {s.number for s in outputs if not s.constant}
    kept = []
    for step in reversed(steps):
        here = [k for k in range(len(step.op.types)) if step.first + k in wanted]
        if here:
            alone = step.op.alone if here == [0] else None
            kept.append(step if alone is None else step._replace(op=alone))
            wanted |= {s.number for s in step.args if not s.constant}
    return kept[::-1]


def components_taken(steps: Sequence[Step], table: ConstantTable) -> list[Step]:
    """Steps that give what another has as its first component take it from there."""

    def key(what: Op, step: Step) -> tuple[Any, ...]:
        return what, step.static, step.shift, *(table.identity(slot) for slot in step.args)

    wholes = {step.op.first_of for step in steps} - {None}
    found = {key(step.op, step): step for step in steps if step.op in wholes}
    taken: list[Step] = []
    for step in steps:
        whole = found.get(key(step.op.first_of, step)) if step.op.first_of is not None else None
        if whole is not None:
            arg = Slot(False, whole.first, whole.op.types[0])
            step = Step(first_component, (), 0, (arg,), step.first)
            if whole not in taken:
                taken.append(whole)
        if step not in taken:
            taken.append(step)
    return taken


def taken_together(steps: Sequence[Step], table: ConstantTable, size: int) -> list[Step]:
    """Steps whose results one op gives jointly take them from there; its results' numbers begin at `size`."""
    groups: dict[tuple[Any, ...], dict[int, int]] = {}
    for step in steps:
        joint = step.op.joint(*step.static)
        if joint is not None:
            what, static, number = joint
            key = what, static, step.shift, *(table.identity(slot) for slot in step.args)
            groups.setdefault(key, {})[step.first] = number
    taken: list[Step] = []
    joint_of = {first: (key[:2], group) for key, group in groups.items() if len(group) > 1 for first in group}
    begins: dict[int, int] = {}
    for step in steps:
        if step.first not in joint_of:
            taken.append(step)
            continue
        (what, static), group = joint_of[step.first]
        if id(group) not in begins:
            begins[id(group)] = size
            taken.append(Step(what, static, step.shift, step.args, size))
            size += len(what.types)
        arg = Slot(False, begins[id(group)] + group[step.first], step.op.types[0])
        taken.append(Step(as_float, (), 0, (arg,), step.first))
    return taken


def components_read(steps: Sequence[Step], outputs: Iterable[Slot]) -> list[Step]:
    """Steps that give no component which nothing reads, where that is less work."""
    wanted = components_wanted(steps, outputs)
    kept = []
    for step in steps:
        some = wanted.get(step.first, set())
        if step.op.part is not None and len(some) < 3:
            step = step._replace(op=step.op.part(tuple(sorted(some))))
        kept.append(step)
    return kept


def components_wanted(steps: Sequence[Step], outputs: Iterable[Slot]) -> dict[int, set[int]]:
    """By result which of its components some steps or outputs read."""
    read = {s.number: {0, 1, 2} for s in outputs if not s.constant}
    for step in reversed(steps):
        results = range(step.first, step.first + len(step.op.types))
        taken = {k for k, number in enumerate(results) if number in read}
        for s in step.args:
            if not s.constant:
                read[s.number] = read.get(s.number, set()) | (taken if step.op.splits else {0, 1, 2})
    return read


def dead_after(steps: Sequence[Step], outputs: Iterable[Slot]) -> list[list[int]]:
    """Per step the results that nothing needs after it, so that their memory can go."""
    kept = {s.number for s in outputs if not s.constant}
    dead: list[list[int]] = []
    for step in reversed(steps):
        touched = {s.number for s in step.args if not s.constant}
        touched |= {step.first + k for k in range(len(step.op.types))}
        dead.append(sorted(touched - kept))
        kept |= touched
    return dead[::-1]
