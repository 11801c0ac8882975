"""The pipeline in float64 (`bench.double`) takes the same samples, to the last places of float32."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.error_scenes import scenes
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot_io import load_snapshot, save_snapshot

ROOT = Path(__file__).resolve().parents[2]
SIZE = {"width": 12, "height": 8, "samples": 1, "threads": 1, "max_depth": 5}
IN_DOUBLE = f"""
import sys
sys.path.insert(0, {str(ROOT)!r})
from bench.double import enter
enter()
import numpy
from pt_engine.render import integrators
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot_io import load_snapshot
for name in sys.argv[1:]:
    image = render(prepare(load_snapshot(name)), RenderSettings(**{SIZE!r})).image()
    numpy.save(name + ".npy", numpy.asarray(image, numpy.float64))
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """In float32 and in float64, by scene."""
    folder = tmp_path_factory.mktemp("double")
    files = {name: folder / f"{k}.snapshot" for k, name in enumerate(("diffuse ball in a room", "mirror"))}
    for name, file in files.items():
        save_snapshot(scenes()[name], file)
    subprocess.run([sys.executable, "-c", IN_DOUBLE, *map(str, files.values())], check=True)
    return {
        name: (render(prepare(load_snapshot(file)), RenderSettings(**SIZE)).image(), np.load(f"{file}.npy"))
        for name, file in files.items()
    }


@pytest.mark.parametrize("name", ["diffuse ball in a room", "mirror"])
def test_samples_are_those_of_float64(pictures, name):
    """docs/error-growth.md: all within 4e-4; and they are not the very same numbers."""
    single, double = (picture.astype(np.float64) for picture in pictures[name])
    assert single[..., :3].mean() > 0.01
    np.testing.assert_allclose(single, double, rtol=1e-3, atol=1e-7)
    assert (single != double).any()
