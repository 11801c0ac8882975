"""What the scripts share: the virtual environment (.venv or $PT_VENV) and running things in it."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = Path(os.environ.get("PT_VENV") or ROOT / ".venv").absolute()
PYTHON = str(VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))


def run(*arguments):
    """Run the environment's Python in the project's folder; leave with its code if it fails."""
    code = subprocess.call([PYTHON, *arguments], cwd=ROOT)
    if code:
        sys.exit(code)
