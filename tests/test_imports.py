"""The engine right of the snapshot runs where there is no Blender."""

import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "pt_engine"

IMPORT_ALL = """
import importlib, sys
sys.modules.update({"bpy": None, "mathutils": None, "gpu": None})  # importing them now fails
for name in sys.argv[1:]:
    importlib.import_module(name)
"""


def modules_outside_blender() -> list[str]:
    """Dotted names of all modules but those of `blender/` and the command line's entry."""
    names = []
    for path in sorted(PACKAGE.rglob("*.py")):
        inside = path.relative_to(PACKAGE.parent).with_suffix("")
        if "blender" not in inside.parts and inside.name != "__main__":
            names.append(".".join(inside.parts).removesuffix(".__init__"))
    return names


def test_every_module_outside_blender_imports_without_bpy():
    names = modules_outside_blender()
    assert len(names) > 50
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", IMPORT_ALL, *names],
        cwd=PACKAGE.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
