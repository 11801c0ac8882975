"""Integrators of a user's own: Python files that register one, loaded only when the user asks.

A file says `from pt_engine.render.integrator import Integrator`. As an extension the package has another
name (`bl_ext.user_default.pt_engine.pt_engine`); an import hook makes the short one mean the same modules.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.abc
import importlib.util
import sys
from pathlib import Path

from ..render import integrators  # noqa: F401  the built-in ones come first
from ..render.integrator import INTEGRATORS

PACKAGE = __name__.removesuffix(".blender.plugins")
SHORT = "pt_engine"
SEPARATOR = ";"
_loaded: dict[Path, dict[str, type]] = {}


class PluginError(RuntimeError):
    """A user's file could not be loaded, and why."""


class ShortName(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """`pt_engine.x` is the very module `bl_ext.….pt_engine.x`."""

    def find_spec(self, name, path=None, target=None):
        if name != SHORT and not name.startswith(SHORT + "."):
            return None
        return importlib.util.spec_from_loader(name, self)

    def create_module(self, spec):
        module = importlib.import_module(PACKAGE + spec.name[len(SHORT) :])
        spec.loader_state = (module, module.__spec__, module.__loader__)
        return module

    def exec_module(self, module):
        # the import system has given the module the short name's spec: it keeps its own
        _, module.__spec__, module.__loader__ = module.__spec__.loader_state


_hook = ShortName()


def install_short_name() -> None:
    """Let user files say `pt_engine` where the package has another name."""
    if PACKAGE != SHORT and _hook not in sys.meta_path:
        sys.meta_path.insert(0, _hook)


def remove_short_name() -> None:
    """Undo `install_short_name`."""
    if _hook in sys.meta_path:
        sys.meta_path.remove(_hook)
        for name in [n for n in sys.modules if n == SHORT or n.startswith(SHORT + ".")]:
            del sys.modules[name]


def load(path: str | Path) -> list[str]:
    """Run a user's file; the names of the integrators that it registers.

    Loading a file again replaces what it registered before.

    Raises
    ------
    PluginError
        The file is missing, raises, registers nothing, or takes the name of another integrator.
    """
    path = Path(path).resolve()
    if not path.is_file():
        raise PluginError(f"no such file: {path}")
    for name, cls in _loaded.pop(path, {}).items():
        if INTEGRATORS.get(name) is cls:
            del INTEGRATORS[name]
    before = dict(INTEGRATORS)
    try:
        _run(path)
        _loaded[path] = {name: cls for name, cls in INTEGRATORS.items() if before.get(name) is not cls}
        if taken := sorted(set(_loaded[path]) & set(before)):
            raise PluginError(f"{path.name} takes the name of an integrator that exists: {', '.join(taken)}")
        if not _loaded[path]:
            raise PluginError(f"{path.name} registers no integrator: subclass Integrator and give it a name")
    except BaseException:
        _loaded.pop(path, None)
        INTEGRATORS.clear()
        INTEGRATORS.update(before)
        raise
    return list(_loaded[path])


def _run(path: Path) -> None:
    """Import the file under a name of its own."""
    install_short_name()
    name = f"pt_engine_user_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise PluginError(f"not a Python file: {path}")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise PluginError(f"{path.name} can't be loaded: {type(error).__name__}: {error}") from error


def load_all(paths: str) -> list[str]:
    """Load every file of a list separated by semicolons; the names registered."""
    files = [part.strip() for part in paths.split(SEPARATOR) if part.strip()]
    return [name for file in files for name in load(file)]
