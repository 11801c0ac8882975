"""What the suite tries a few times, tried a thousand times: damaged files, view layers, renders, stops.

`python -m bench.limits` writes docs/limits.md; each part is a process of its own (`python -m bench.limits
PART`), damaged files have many.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from . import machine

DAMAGED, SEED = 1000, 7
LAYERS, CYCLES, CANCELS = 1000, 100, 200
TESTS = str(machine.ROOT / "tests")
TEXT = """# Limits

`python -m bench.limits` writes this page; the suite tries less of the same (tests/blender/test_limits.py,
test_blend_fuzz.py, tests/scene/test_fuzz.py). {machine}

## Damaged files

Files of a scene with textures, bumps, instances, links, lamps, hair, and things that move: cut off, bytes
flipped, words and numbers of their data replaced by hard ones (NaN, infinity, 2³¹, 10³⁰ …). Each is opened,
prepared and rendered in a child process. The end has to be a picture of finite numbers or a clear error;
Blender's own reader may die of a .blend, the engine's code may not.

| how it ended | {damaged:,} snapshots | {damaged:,} .blend files |
| --- | --- | --- |
{fates}

## Many of everything

| what | found |
| --- | --- |
{rows}
"""


def fates(module: str) -> dict[str, int]:
    """How damaged files ended, in few words."""
    told = json.loads(machine.run([f"support.{module}", str(DAMAGED), str(SEED)])[0])
    found: dict[str, int] = {}
    for how, number in told.items():
        name = short(how)
        found[name] = found.get(name, 0) + number
    return found


def short(how: str) -> str:
    """A kind of end."""
    if how.startswith(("refused", "told")):
        return "a clear error"
    if how.startswith("Blender died"):
        asked = "export" in how.partition(":")[0]
        return "Blender died as it was asked for what it had read" if asked else "Blender died of opening it"
    return "a picture" if how == "rendered" else f"**{how}**"


def layers() -> list[str]:
    """Of a thousand view layers."""
    from support.limits import seconds_of_layers

    with tempfile.TemporaryDirectory() as folder:
        *seconds, whole = seconds_of_layers(LAYERS, Path(folder))
    first, last = (1e3 * float(np.median(part)) for part in (seconds[:100], seconds[-100:]))
    text = f"{whole:.0f} s; ours for one: {first:.0f} ms of the first hundred, {last:.0f} ms of the last"
    return [f"a render of {LAYERS:,} view layers, 8 × 8 pixels", text]


def cycles() -> list[str]:
    """Of a hundred renders."""
    from support.limits import resident_after_renders

    with tempfile.TemporaryDirectory() as folder:
        sizes = np.array(resident_after_renders(CYCLES, Path(folder))) / 1e6
    text = f"{np.median(sizes[20:30]):.0f} MB resident after 25, {np.median(sizes[-10:]):.0f} MB at the end"
    return [f"a file opened and rendered {CYCLES} times", text]


def cancels() -> list[str]:
    """Of two hundred stops."""
    from support.limits import cancelled

    with tempfile.TemporaryDirectory() as folder:
        stopped = cancelled(CANCELS, Path(folder))
    text = f"{stopped} before their end; each leaves a picture of finite numbers and no thread"
    return [f"{CANCELS} renders stopped at random moments", text]


PARTS: dict[str, Callable[[], list[str]]] = {"layers": layers, "cycles": cycles, "cancels": cancels}


def rows() -> list[list[str]]:
    """Of all parts, each in a process of its own."""
    return [json.loads(machine.run(["bench.limits", part])[0].splitlines()[-1]) for part in PARTS]


def page(snapshots: dict[str, int], blends: dict[str, int], others: list[list[str]], where: str) -> str:
    """The text."""
    kinds = sorted(snapshots | blends, key=lambda kind: -snapshots.get(kind, 0) - blends.get(kind, 0))
    ends = [f"| {kind} | {snapshots.get(kind, 0)} | {blends.get(kind, 0)} |" for kind in kinds]
    many = [f"| {what} | {found} |" for what, found in others]
    return TEXT.format(damaged=DAMAGED, fates="\n".join(ends), rows="\n".join(many), machine=where)


def main() -> None:
    """All of it."""
    os.environ["PYTHONPATH"] = TESTS
    about: dict[str, Any] = machine.description()
    where = f"{about['processor']}, {about['cores']} cores."
    text = page(fates("fuzz"), fates("blend_fuzz"), rows(), where)
    (machine.ROOT / "docs" / "limits.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) == 2:
        print(json.dumps(PARTS[sys.argv[1]]()))
    else:
        main()
