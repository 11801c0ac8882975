"""A sample of a public library's node materials: they render finite, and like Cycles where they say so.

The files are not part of the project: see tests/support/materials.py; `python -m bench.materials_library`
takes all of them.
"""

import pytest

bpy = pytest.importorskip("bpy")
from support import materials  # noqa: E402

SAMPLE = 20
pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender 5 converts the old files")


def sampled():
    """(file, name) of every so-many-th material, of all files."""
    folder = materials.library()
    if folder is None:
        reason = "no material library: set PT_MATERIALS to the folder of its .blend files"
        return [pytest.param(None, "", marks=pytest.mark.skip(reason=reason))]
    every = [(file, name) for file in sorted(folder.glob("*.blend")) for name in materials.names(file)]
    step = len(every) // SAMPLE
    return [pytest.param(*pair, id=f"{pair[0].stem}: {pair[1]}") for pair in every[step // 2 :: step]]


@pytest.mark.parametrize(("file", "name"), sampled())
def test_material_renders_finite_and_like_cycles_where_exact(file, name):
    found = materials.tried(file, name, size=16, samples=4)
    assert found.failure == ""
    assert found.finite
    assert not found.differs, found
