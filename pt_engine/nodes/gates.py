"""Work left out where it cannot be seen: textures behind a mask are computed where it lets something through.

A closure's weight is a product, and where a factor of it is 0 the closure's other values do not matter, nor
do the factors after it. Such a factor is a *gate*. Of the steps that cost much those whose results are only
read behind gates run on the lanes where one of these is not 0; on the others their results are 0, as if the
texture were black there. A noise whose Factor is read on more lanes than its Color is computed in two parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .ir import COLOR, FLOAT, first_component, sums
from .program import ConstantTable, Entry, Slot, Step, Structure, components_wanted, dead_after

Float32 = NDArray[np.float32]
ALWAYS: Final = -1  # where a result is read on all lanes


class Gates:
    """Which steps of a program are gated, and an order in which gates come first.

    Parameters
    ----------
    steps : list of Step
    read_where : iterable of (Slot, Slot or None)
        The program's outputs, each with the weight without which it does not matter.
    """

    def __init__(self, steps: Sequence[Step], read_where: Iterable[tuple[Slot, Slot | None]]) -> None:
        self._steps = list(steps)
        self._maker = {s.first + k: n for n, s in enumerate(steps) for k in range(len(s.op.types))}
        self._first = [[self._maker[a.number] for a in s.args if not a.constant] for s in steps]
        self._needed = [0] * len(steps)  # bit k: not before step k
        for number in range(len(steps)):
            self._needed[number] = self._with_needs(number)
        self._zeros: dict[int, list[int]] = {}
        self.of: list[tuple[int, ...]] = [()] * len(steps)
        read = self._read_behind(read_where)
        for number, step in enumerate(steps):
            if step.op.dear and ALWAYS not in read[number]:
                self.of[number] = self._chosen(number, read[number])
                self._put_first(number, [self._maker[g] for g in self.of[number]])

    def _with_needs(self, number: int) -> int:
        bits = 1 << number
        for first in self._first[number]:
            bits |= self._needed[first]
        return bits

    def _put_first(self, number: int, gates: list[int]) -> None:
        """Have a step, and with it all that needs it, wait for some others."""
        self._first[number] += gates
        more = self._with_needs(number)
        if more != self._needed[number]:
            self._needed = [bits | more if bits >> number & 1 else bits for bits in self._needed]

    def _read_behind(self, read_where: Iterable[tuple[Slot, Slot | None]]) -> list[set[int]]:
        """For each step the numbers behind which its results are read."""
        read: list[set[int]] = [set() for _ in self._steps]
        for slot, weight in read_where:
            if not slot.constant:
                alone = weight is None or weight.constant
                read[self._maker[slot.number]].add(ALWAYS if alone or weight is None else weight.number)
        for number in reversed(range(len(self._steps))):
            factors = [a.number for a in self._steps[number].args if not a.constant]
            gated = self._steps[number].op.keeps_zero and len(factors) == 2
            for k, factor in enumerate(factors):
                read[self._maker[factor]] |= {factors[0]} if gated and k else read[number]
        return read

    def zeros_of(self, number: int) -> list[int]:
        """The numbers, one per lane, that make a result 0 where they are 0; what is nearest to it first."""
        if number not in self._zeros:
            factors = [number]
            for factor in factors:  # grows
                step = self._steps[self._maker[factor]]
                if step.op.keeps_zero:
                    factors += [a.number for a in step.args if not a.constant and a.number not in factors]
            self._zeros[number] = [n for n in factors if self._type(n) == FLOAT]
        return self._zeros[number]

    def _type(self, number: int) -> str:
        step = self._steps[self._maker[number]]
        return step.op.types[number - step.first]

    def _chosen(self, number: int, behind: set[int]) -> tuple[int, ...]:
        """The gates of a step whose results are read behind some numbers; none if one of these has none."""
        gates = set()
        for result in sorted(behind):
            free = (g for g in self.zeros_of(result) if not self._needed[self._maker[g]] >> number & 1)
            gate = next(free, None)
            if gate is None:
                return ()
            gates.add(gate)
        return tuple(sorted(g for g in gates if not gates & set(self.zeros_of(g)[1:])))

    def order(self) -> list[int]:
        """The steps' numbers, each after all that it needs, else as they were."""
        done: dict[int, None] = {}
        for last in range(len(self._steps)):
            stack = [last]
            while stack:
                missing = [n for n in self._first[stack[-1]] if n not in done]
                if missing:
                    stack += missing[::-1]
                else:
                    done[stack.pop()] = None
        return list(done)


class GatedEntry(Entry):
    """An entry that computes closures' values, dear ones only where they matter.

    Parameters
    ----------
    structure, table, roots
        As for `Entry`.
    weight_of : sequence of int
        For each root the one of `roots`' places that is its weight; −1 for what matters everywhere.
    """

    def __init__(
        self, structure: Structure, table: ConstantTable, roots: Sequence[int], weight_of: Sequence[int]
    ) -> None:
        super().__init__(structure, table, roots)
        weights = [self.outputs[w] if w >= 0 else None for w in weight_of]
        read_where = list(zip(self.outputs, weights, strict=True))
        steps = with_firsts_apart(self.steps, self.outputs, read_where, self._size)
        gates = Gates(steps, read_where)
        self.steps = [behind(gates.of[k], steps[k]) for k in gates.order()]
        self._size = max([self._size, *(s.first + len(s.op.types) for s in self.steps)])
        self._dead = dead_after(self.steps, self.outputs)


Parts = tuple[Step, Step, Step]


def firsts_apart(steps: Sequence[Step], outputs: Sequence[Slot], size: int) -> dict[int, Parts]:
    """For steps whose first component some read alone: it, what else is read, and their sum, by the result.

    The first two results' numbers begin at `size`; the sum has the step's own.
    """
    alone = {s.args[0].number for s in steps if s.op is first_component}
    read = components_wanted([s for s in steps if s.op is not first_component], outputs)
    parts: dict[int, Parts] = {}
    for step in steps:
        rest = sorted(read.get(step.first, set()) - {0})
        if step.op.part is None or not step.op.dear or step.first not in alone or not rest:
            continue
        first, others = (
            Step(step.op.part(channels), step.static, step.shift, step.args, size + k)
            for k, channels in enumerate(((0,), tuple(rest)))
        )
        slots = tuple(Slot(False, part.first, step.op.types[0]) for part in (first, others))
        parts[step.first] = first, others, Step(sums[COLOR], (), 0, slots, step.first)
        size += 2
    return parts


def with_firsts_apart(
    steps: Sequence[Step],
    outputs: Sequence[Slot],
    read_where: Sequence[tuple[Slot, Slot | None]],
    size: int,
) -> list[Step]:
    """Steps, of which some are apart as `firsts_apart` has it: where the rest is wanted on fewer lanes."""
    parts = firsts_apart(steps, outputs, size)
    if not parts:
        return list(steps)
    apart = replaced(steps, parts)
    of = dict(zip((s.first for s in apart), Gates(apart, read_where).of, strict=True))
    fewer = (k for k, (first, rest, _) in parts.items() if of[rest.first] not in ((), of[first.first]))
    return replaced(steps, {k: parts[k] for k in fewer})


def replaced(steps: Sequence[Step], parts: dict[int, Parts]) -> list[Step]:
    """Steps with some in parts, from the first of which those take the first component that read it alone."""
    out: list[Step] = []
    for step in steps:
        if step.op is first_component and step.args[0].number in parts:
            first = parts[step.args[0].number][0].first
            step = step._replace(args=(step.args[0]._replace(number=first),))
        out += parts.get(step.first, (step,))
    return out


def behind(gates: tuple[int, ...], step: Step) -> Step:
    """A step that looks at some gates, its last arguments, before it computes."""
    if not gates:
        return step
    own, types, before = step.op.function, step.op.types, len(step.static)

    @wraps(own)
    def function(*arguments: Any) -> Any:
        given, masks = arguments[: -len(gates)], arguments[-len(gates) :]
        if any(mask.size == 1 or mask.all() for mask in masks):
            return own(*given)
        is_open = masks[0] != 0
        for mask in masks[1:]:
            is_open |= mask != 0
        lanes = np.flatnonzero(is_open)
        results = [np.zeros((is_open.size,) if t == FLOAT else (3, is_open.size), np.float32) for t in types]
        if len(lanes):
            some = [a if a.shape[-1] == 1 else a.take(lanes, axis=-1) for a in given[before:]]
            out = own(*given[:before], *some)
            for result, value in zip(results, out if len(types) > 1 else (out,), strict=True):
                put(result, lanes, value)
        return results if len(types) > 1 else results[0]

    slots = tuple(Slot(False, gate, FLOAT) for gate in gates)
    return step._replace(op=replace(step.op, function=function, gates=len(gates)), args=step.args + slots)


def put(result: Float32, lanes: NDArray[np.intp], value: Float32) -> None:
    """Set some lanes of a number (n,) or of three (3, n)."""
    size = result.shape[-1]
    for row, some in zip(result.reshape(-1, size), value.reshape(-1, value.shape[-1]), strict=True):
        row[lanes] = some
