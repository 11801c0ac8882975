"""Damaged .blend files end in a picture or a clear error, or in Blender's own hands; never in ours."""

import pytest
from support.blend_fuzz import tried

COUNT = 30  # a thousand in docs/limits.md


@pytest.mark.slow
def test_damaged_files_are_rendered_or_refused():
    """Cut off, or with words of their data blocks changed: opened, exported, prepared and rendered."""
    found = tried(COUNT, 3)
    assert sum(found.values()) == COUNT
    fine = ("rendered", "refused", "Blender died")
    assert {how: number for how, number in found.items() if not how.startswith(fine)} == {}
    assert found["rendered"] >= COUNT // 4  # so that the rooms behind Blender's reader are tried, too
    assert found["refused by Blender"] >= 1
