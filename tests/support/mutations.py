"""Formulas broken on purpose, one at a time in a copy of the tree: the tests have to notice each.

`scripts/mutate` runs them all and prints a table; names as arguments pick some.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .mutated_formulas import FORMULAS, Mutation
from .mutated_scenes import SCENES

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("pt_engine", "tests", "examples", "scenes", "pyproject.toml")


MUTATIONS = (*FORMULAS, *SCENES)


def caught(mutation: Mutation, tree: Path) -> bool:
    """Whether the mutation's tests fail on a tree that has it. The tree is as before afterwards."""
    path = tree / "pt_engine" / mutation.file
    sound = path.read_text(encoding="utf-8")
    if sound.count(mutation.right) != 1:
        raise ValueError(f"{mutation.file} no longer has one {mutation.right!r}")
    path.write_text(sound.replace(mutation.right, mutation.wrong), encoding="utf-8")
    try:
        return tested(mutation.tests, tree) == 1
    finally:
        path.write_text(sound, encoding="utf-8")


def tested(tests: str, tree: Path) -> int:
    """pytest's exit code: 0 all passed, 1 some failed, else it could not even run."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow"]
    quiet = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [*command, *tests.split()], cwd=tree, env=quiet, capture_output=True, check=False
    ).returncode


def main(names: list[str]) -> int:
    """Try all mutations, or those whose names hold one of `names`; how many went unnoticed."""
    chosen = [m for m in MUTATIONS if not names or any(name in m.name for name in names)]
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, tree / name)
        for mutation in chosen:
            started = time.perf_counter()
            noticed = caught(mutation, tree)
            missed += not noticed
            verdict = "caught" if noticed else "MISSED"
            print(
                f"{verdict}  {mutation.name}  ({mutation.file}, {time.perf_counter() - started:.1f} s)",
                flush=True,
            )
    print(f"{len(chosen) - missed} of {len(chosen)} caught")
    return missed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
