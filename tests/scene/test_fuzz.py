"""Damaged snapshots, in a process of their own: pictures or clear errors, and no crash."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COUNT = 250  # a thousand of them, and of .blend files, in docs/limits.md


@pytest.mark.slow
def test_damaged_snapshots_are_refused_or_rendered():
    """Cut, flipped and repacked with other numbers and words: load, prepare and render one sample of each."""
    path = f"import sys; sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / 'tests')!r}]"
    run = f"{path}; from support.fuzz import main; sys.argv[1:] = ['{COUNT}', '7']; main()"
    child = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", run], capture_output=True, text=True, check=False
    )
    assert child.returncode == 0, child.stderr[-2000:]
    found = json.loads(child.stdout)
    assert sum(found.values()) == COUNT
    clear = {
        name: number for name, number in found.items() if name.startswith(("refused", "rendered", "told"))
    }
    assert clear == found, set(found) - set(clear)
    assert found["refused"] > COUNT // 4
    assert found["rendered"] > COUNT // 4  # so that the rooms behind the reader are tried, too
