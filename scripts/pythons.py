"""Which Python to take: $PYTHON alone where it is set, else the first that works and has a lock file."""

import os
import subprocess
import sys

USUAL = [["python3.13"], ["python3.11"], ["python3"], ["py", "-3.13"], ["py", "-3.11"], [sys.executable]]
COMMANDS = [[os.environ["PYTHON"]]] if os.environ.get("PYTHON") else USUAL
PROBE = "import ensurepip, venv, sys; print('py%d%d' % sys.version_info[:2])"


def python_version(command):
    """`py313` or the like; empty where the command does not work (a pyenv shim may exist and fail)."""
    try:
        return subprocess.run([*command, "-c", PROBE], capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


PYTHON = next((c for c in COMMANDS if python_version(c) in ("py313", "py311")), None)
