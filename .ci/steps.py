#!/usr/bin/env python3
"""Everything CI checks, from a clean clone; a step that fails does not stop the others.

    .ci/run [STEP ...]        all steps, or those whose name contains one of the words (run calls this file)

The tests have both cores, a process on each; steps that keep one core busy run in pairs.

Finds Python 3.13 and 3.11 on the PATH or in pyenv. The steps in the real Blender need what
`scripts/blender` can install; where it cannot, they are skipped, and the last lines say so.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
os.chdir(ROOT)
os.environ["CI"] = "true"


def interpreter(version):
    """Path of a working Python of this version, or None."""
    found = [shutil.which(f"python{version}")]
    if shutil.which("pyenv"):
        prefix = subprocess.run(["pyenv", "prefix", version], capture_output=True, text=True).stdout.strip()
        found.append(f"{prefix}/bin/python")
    for path in found:
        try:
            if path and subprocess.run([path, "-c", "import ensurepip"], capture_output=True).returncode == 0:
                return path
        except OSError:
            continue
    return None


def blender():
    """Path of a real Blender, installed if need be, or None."""
    if os.environ.get("PT_BLENDER"):
        return os.environ["PT_BLENDER"]
    script = ROOT / "scripts" / "blender"
    if not script.exists():
        return None
    print("\n=== installing Blender", flush=True)
    start = time.monotonic()
    printed = subprocess.run([str(script)], stdout=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)
    print(f"=== installing Blender: code {printed.returncode}, {time.monotonic() - start:.0f} s", flush=True)
    lines = printed.stdout.strip().splitlines()
    return lines[-1] if printed.returncode == 0 and lines else None


class Steps:
    """Runs commands one after the other and keeps what became of each."""

    def __init__(self, words):
        self.words, self.results = words, []

    def wanted(self, name):
        return not self.words or any(word in name for word in self.words)

    def run(self, name, command, environment, output=None):
        """Run `command` as the step `name`; without a Python it fails, without a Blender it is skipped."""
        missing = [key for key, value in environment.items() if value is None]
        print(f"\n=== {name}: {' '.join(command)}", flush=True)
        start = time.monotonic()
        if missing:  # scripts/blender has said why
            verdict = "FAILED (no such Python here)" if "PYTHON" in missing else "skipped (no Blender here)"
        else:
            streams = {"stdin": subprocess.DEVNULL, "stdout": output, "stderr": output}
            code = subprocess.call(command, env={**os.environ, **environment}, **streams)
            verdict = "ok" if code == 0 else f"FAILED (code {code})"
        self.results.append((name, time.monotonic() - start, verdict))
        if output:
            output.seek(0)
            print(f"\n=== what {name} printed\n{output.read()}", end="")
        print(f"=== {name}: {verdict}, {self.results[-1][1]:.0f} s", flush=True)

    def pair(self, *steps):
        """Run the wanted ones of these (name, command, environment) side by side, each printed as it ends."""
        wanted = [step for step in steps if self.wanted(step[0])]
        with ExitStack() as files, ThreadPoolExecutor() as pool:
            runs = []
            for step in wanted:
                beside = len(wanted) > 1
                output = (
                    files.enter_context(tempfile.TemporaryFile("w+", errors="replace")) if beside else None
                )
                runs.append(pool.submit(self.run, *step, output))
            for run in runs:
                run.result()

    def report(self):
        print()
        for name, seconds, verdict in self.results:
            print(f"{seconds:7.0f} s  {name:24} {verdict}")
        failed = sum("FAILED" in verdict for _, _, verdict in self.results)
        print(f"{len(self.results) - failed} steps done or skipped, {failed} steps failed")
        return 1 if failed else 0


def main(words):
    steps = Steps(words)
    new = {"PYTHON": interpreter("3.13"), "PT_VENV": str(ROOT / ".venv313")}
    old = {"PYTHON": interpreter("3.11"), "PT_VENV": str(ROOT / ".venv311")}

    def script(name, *arguments):
        return [sys.executable, f"scripts/{name}", *arguments]

    steps.pair(
        ("setup 3.13", script("setup", "--test"), new),
        ("setup 3.11", script("setup", "--test"), old),
    )
    real = {**new, "PT_BLENDER": blender() if steps.wanted("real Blender") else None}
    steps.pair(
        ("lint 3.13", script("lint"), new),
        ("real Blender", script("test", "-q", "-n", "0", "tests/real_blender"), real),  # one window at a time
    )
    steps.pair(("tests 3.13", script("test", "-q"), new))
    steps.pair(("tests 3.11", script("test", "-q", "-m", "not slow"), old))
    steps.pair(("demo", script("demo", "--size", "160x90", "--samples", "8"), new))
    return steps.report()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
