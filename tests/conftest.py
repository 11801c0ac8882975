"""How a test run ends, and what tests of every room share."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

import pytest


@pytest.fixture
def own_integrators() -> Iterator[None]:
    """Integrators registered by a test are gone after it."""
    from pt_engine.render import integrators  # noqa: F401  (fills the registry)
    from pt_engine.render.integrator import INTEGRATORS

    before = dict(INTEGRATORS)
    yield
    INTEGRATORS.clear()
    INTEGRATORS.update(before)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Remember the result for `pytest_unconfigure`."""
    session.config.stash[RESULT] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """bpy 4.5's own shutdown, after many files were loaded in one process, may never end: leave before it."""
    bpy = sys.modules.get("bpy")
    if bpy is not None and bpy.app.version < (5, 0) and RESULT in config.stash:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.stash[RESULT])


RESULT = pytest.StashKey[int]()
