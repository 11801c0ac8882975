"""Which Python to take."""

import os
import subprocess
import sys

PROBE = "import ensurepip, venv, sys; print('py%d%d' % sys.version_info[:2])"
COMMANDS = [["python3.13"], ["python3.11"], ["python3"], ["py", "-3.13"], ["py", "-3.11"], [sys.executable]]


def python_version(command):
    """`py313` or the like; empty where the command does not work (a pyenv shim may exist and fail)."""
    try:
        return subprocess.run([*command, "-c", PROBE], capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def python():
    """The first command that is a Python with a lock file; $PYTHON alone where it is set."""
    mine = [[os.environ["PYTHON"]]] if os.environ.get("PYTHON") else COMMANDS
    return next((c for c in mine if python_version(c) in ("py313", "py311")), None)
