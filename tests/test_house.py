"""The house rules that no linter knows: sizes, and who may import what."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted((ROOT / "pt_engine").rglob("*.py"))
OTHERS = [
    path
    for folder in ("tests", "scenes", "bench", "examples", "tools")
    for path in (ROOT / folder).rglob("*.py")
]
SCRIPTS = sorted(path for path in (ROOT / "scripts").iterdir() if path.is_file())

# Module: the places that may import it, as path prefixes below pt_engine/.
KEEPERS = {
    "bpy": ("blender/",),
    "mathutils": ("blender/",),
    "gpu": ("blender/",),
    "embreex": ("scene/accel.py",),
    "OpenImageIO": ("textures/", "render/write_exr.py"),
    "pickle": (),  # a snapshot from a stranger must not run code
    "scipy": (),  # for tests only
}


@cache
def imported(path: Path) -> set[str]:
    """Top-level names of the absolute imports of a file, wherever in it they stand."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.partition(".")[0])
    return names


@pytest.mark.parametrize("module", KEEPERS)
def test_only_its_keeper_imports(module):
    strangers = [
        name
        for path in SOURCES
        if module in imported(path)
        and not (name := path.relative_to(ROOT / "pt_engine").as_posix()).startswith(
            KEEPERS[module] or ("-",)
        )
    ]
    assert not strangers


def test_the_package_names_itself_relatively():
    """As an extension it lives at bl_ext.user_default.pt_engine.pt_engine."""
    assert not [path for path in SOURCES if "pt_engine" in imported(path)]


def test_files_hold_one_subject():
    """More than 400 lines are two subjects."""
    lengths = {path.relative_to(ROOT).as_posix(): lines(path) for path in [*SOURCES, *OTHERS]}
    assert not {name: n for name, n in lengths.items() if n > 400}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_scripts_are_short(script):
    """What people type; what is behind it is in the package or in tools/."""
    assert lines(script) <= 20


def lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())
