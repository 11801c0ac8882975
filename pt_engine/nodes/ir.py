"""The intermediate form of a shader: pure calls on values, interned so that equal work is one object.

A value is a batch of scalars `(n,)` or of 3-vectors `(3, n)`; constants have n = 1 and broadcast. A
`Call` applies an `Op` to values; building the same call twice gives the same object (common
sub-expressions), and a call whose arguments are all constant is evaluated at once (constant folding).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]

FLOAT: Final = "float"
COLOR: Final = "color"
VECTOR: Final = "vector"

Static = tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Op:
    """One thing a program can do.

    Attributes
    ----------
    function : callable
        `function(*static, *arrays)`, or `function(lanes, *static, *arrays)` where `lanes` is true; gives
        one array, or a tuple where `types` has several.
    types : tuple of str
        FLOAT, COLOR or VECTOR of each output.
    lanes : bool
        Reads the lanes, so it is never folded.
    moves : bool
        Reads something that changes along the surface (Bump evaluates it at shifted positions).
    reads : callable
        Static arguments → names of the lane attributes it needs.
    first_of : Op, optional
        One that gives three components from the same arguments, this one's result the first of them.
    alone : Op, optional
        One that gives the first of its results and no other, for less work.
    part : callable, optional
        Some of the numbers 0, 1, 2 → an op that gives only these components of its result, for less work.
    joint : callable, optional
        Static arguments → another op that gives this one's result and more from the same arguments for less
        work, its static arguments, and which result it is; None where there is none.
    splits : bool
        Its result number k is component k of its argument, and needs no other.
    keeps_zero : bool
        Its result is 0 where any argument is.
    dear : bool
        Costs much more than choosing among lanes does.
    gates : int
        How many of its last arguments say where it is wanted (see `gates`).
    rest : tuple of str
        What the arguments are that the function takes together as `*arguments`.
    """

    function: Callable[..., Any]
    types: tuple[str, ...]
    lanes: bool = False
    moves: bool = False
    reads: Callable[..., tuple[str, ...]] = lambda *_: ()
    first_of: Op | None = None
    rest: tuple[str, ...] = ()
    alone: Op | None = None
    part: Callable[[tuple[int, ...]], Op] | None = None
    joint: Callable[..., tuple[Op, Static, int] | None] = lambda *_: None
    splits: bool = False
    keeps_zero: bool = False
    dear: bool = False
    gates: int = 0

    @property
    def name(self) -> str:
        return self.function.__name__

    def __call__(self, *args: Any) -> Any:
        return self.function(*args)

    def with_function(self, function: Callable[..., Any]) -> Op:
        """The same with another function, for measurements."""
        return replace(self, function=function)


def op(
    *types: str,
    rest: tuple[str, ...] = (),
    alone: Op | None = None,
    joint: Callable[..., tuple[Op, Static, int] | None] = lambda *_: None,
    dear: bool = False,
) -> Callable[[Callable[..., Any]], Op]:
    """Make a pure function of arrays an `Op`."""
    return lambda function: Op(function, types, rest=rest, alone=alone, joint=joint, dear=dear)


def lane_op(
    *types: str, moves: bool = False, reads: str | Callable[..., tuple[str, ...]] = ""
) -> Callable[[Callable[..., Any]], Op]:
    """Make a function of the lanes an `Op`; `reads` names the lane attribute it needs."""
    needs = reads if callable(reads) else (lambda *_: (reads,) if reads else ())
    return lambda function: Op(function, types, True, moves, needs)


@dataclass(frozen=True, eq=False)
class Value:
    """Something a program computes; `type` is FLOAT, COLOR or VECTOR."""

    type: str


@dataclass(frozen=True, eq=False)
class Const(Value):
    """A constant, (1,) or (3, 1) float32."""

    data: Float32

    def is_all(self, number: float) -> bool:
        """Whether every component equals `number`."""
        return bool((self.data == number).all())


@dataclass(frozen=True, eq=False)
class Call:
    """An op applied to values; `shift` is 0 here, or one of Bump's shifted positions (see `shift_code`)."""

    op: Op
    static: Static
    args: tuple[Value, ...]
    shift: int = 0


@dataclass(frozen=True, eq=False)
class Result(Value):
    """Output number `index` of a call."""

    call: Call
    index: int = 0


REST = 4  # bit of a shift: the surface before displacement


def shift_code(axis: int, width: float) -> int:
    """A position one step along `axis` (1 or 2), `width` of a pixel's footprint long, as one number.

    With `REST` added, the same on the surface before displacement; `REST` alone is the point itself there.
    """
    return int(np.float32(width).view(np.uint32)) << 3 | axis


def shift_of(code: int) -> tuple[int, float]:
    """Axis (with `REST`, if it was added) and width of a `shift_code`."""
    return code & 7, float(np.uint32(code >> 3).view(np.float32))


class Builder:
    """Makes interned calls and constants for one material."""

    def __init__(self) -> None:
        self._constants: dict[tuple[str, bytes], Const] = {}
        self._calls: dict[tuple[Any, ...], tuple[Value, ...]] = {}
        self.zero = self.constant(0.0, FLOAT)
        self.one = self.constant(1.0, FLOAT)

    def constant(self, value: Any, kind: str) -> Const:
        """An interned constant; non-finite components become 0, as Blender's sockets never hold them."""
        data = np.asarray(value, np.float32)
        data = np.where(np.isfinite(data), data, np.float32(0))
        if kind == FLOAT:
            data = data.reshape(-1)[:1]
        else:
            flat = data.reshape(-1)
            flat = np.repeat(flat, 3) if flat.size == 1 else np.resize(flat, 3) if flat.size < 3 else flat[:3]
            data = flat.reshape(3, 1)
        data = np.ascontiguousarray(data)
        return self._constants.setdefault((kind, data.tobytes()), Const(kind, data))

    def call(self, what: Op, *args: Value, static: Static = (), shift: int = 0) -> tuple[Value, ...]:
        """All outputs of an op on `args`."""
        shift = 0 if not what.lanes else shift if what.moves else shift & REST
        key = (what, static, args, shift)
        known = self._calls.get(key)
        if known is None:
            folded = self._fold(what, static, args)
            if folded is None:
                made = Call(what, static, args, shift)
                folded = tuple(Result(t, made, k) for k, t in enumerate(what.types))
            known = self._calls[key] = folded
        return known

    def _fold(self, what: Op, static: Static, args: tuple[Value, ...]) -> tuple[Value, ...] | None:
        if what.lanes:
            return None
        arrays = [a.data for a in args if isinstance(a, Const)]
        if len(arrays) != len(args):
            return None
        with np.errstate(all="ignore"):
            out = what.function(*static, *arrays)
        outputs: Sequence[Any] = out if len(what.types) > 1 else (out,)
        return tuple(self.constant(o, t) for o, t in zip(outputs, what.types, strict=True))

    def multiply(self, a: Value, b: Value) -> Value:
        """a·b, knowing 0 and 1; the product of a float and a colour is a colour."""
        kind = a.type if b.type == FLOAT else b.type
        for x, y in ((a, b), (b, a)):
            if isinstance(x, Const):
                if x.is_all(0):
                    return self.constant(0.0, kind)
                if x.is_all(1) and (y.type == kind or x.type == y.type):
                    return y
        return self.call(_product[kind], a, b)[0]

    def add(self, a: Value, b: Value) -> Value:
        """a + b, knowing 0."""
        kind = a.type if b.type == FLOAT else b.type
        for x, y in ((a, b), (b, a)):
            if isinstance(x, Const) and x.is_all(0) and y.type == kind:
                return y
        return self.call(sums[kind], a, b)[0]

    def complement(self, a: Value) -> Value:
        """1 − a."""
        return self.call(one_minus if a.type == FLOAT else one_minus_color, a)[0]

    def convert(self, value: Value, kind: str) -> Value:
        """Between socket types, as Blender does: grey of a colour, mean of a vector, copies of a number."""
        if value.type == kind:
            return value
        if isinstance(value, Const) and value.type != FLOAT and kind != FLOAT:
            return self.constant(value.data, kind)
        if value.type == FLOAT:
            return self.call(spread_color if kind == COLOR else spread_vector, value)[0]
        if kind == FLOAT:
            return self.call(grey if value.type == COLOR else mean, value)[0]
        return self.call(as_color if kind == COLOR else as_vector, value)[0]


@op(FLOAT)
def grey(c: Float32) -> Float32:
    """Luminance of linear Rec.709, with the digits that Cycles has."""
    y: Float32 = 0.21263909 * c[0] + 0.71516913 * c[1] + 0.07219274 * c[2]
    return y


@op(FLOAT)
def mean(v: Float32) -> Float32:
    """Mean of a vector's components."""
    m: Float32 = (v[0] + v[1] + v[2]) * (1.0 / 3.0)
    return m


def _first(c: Float32) -> Float32:
    """The first of three components."""
    x: Float32 = c[0]
    return x


def _spread(x: Float32) -> Float32:
    """A number as three equal components."""
    return np.broadcast_to(x, (3, x.shape[-1]))


def _same(x: Float32) -> Float32:
    return x


def _multiply(a: Float32, b: Float32) -> Float32:
    product: Float32 = a * b
    return product


def _add(a: Float32, b: Float32) -> Float32:
    total: Float32 = a + b
    return total


def _one_minus(a: Float32) -> Float32:
    rest: Float32 = 1 - a
    return rest


spread_color, spread_vector = (Op(_spread, (t,), keeps_zero=True) for t in (COLOR, VECTOR))
as_color, as_vector = (Op(_same, (t,), keeps_zero=True) for t in (COLOR, VECTOR))
as_float = Op(_same, (FLOAT,), keeps_zero=True)
first_component = Op(_first, (FLOAT,), splits=True)
one_minus, one_minus_color = Op(_one_minus, (FLOAT,)), Op(_one_minus, (COLOR,))
_product = {t: Op(_multiply, (t,), keeps_zero=True) for t in (FLOAT, COLOR, VECTOR)}
sums = {t: Op(_add, (t,)) for t in (FLOAT, COLOR, VECTOR)}
