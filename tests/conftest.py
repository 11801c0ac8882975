"""How a test run ends."""

from __future__ import annotations

import os
import sys

import pytest


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
