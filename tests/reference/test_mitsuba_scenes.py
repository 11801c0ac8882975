"""Scenes and references that Blender had no hand in: Mitsuba's, Tungsten's, and Mitsuba itself."""

import numpy as np
import pytest
from reference.mitsuba_dicts import DICTS
from support.mitsuba_scenes import load_json, load_xml, rendered_by_mitsuba, resized, resolution, snapshot_of
from support.scenes import rendered
from support.shared_scenes import folder_or_skip, read_exr
from support.ztest import cell_means, compare

pytestmark = pytest.mark.slow  # physics that no Python changes


def ours(content, samples, max_depth, **more):
    """Two independent images, top row first, without alpha."""
    snapshot = snapshot_of(content)
    settings = {"samples": samples, "max_depth": max_depth, "threads": 2, "sampler": "sobol", **more}
    pair = [rendered(snapshot, resolution(content), seed=seed, **settings).image() for seed in (0, 1)]
    return tuple(np.ascontiguousarray(image[::-1, :, :3]) for image in pair)


def test_mitsubas_cornell_box():
    """Both at 128², `max_depth` 8, box filter: every cell within noise, all of it within 0.5 %."""
    folder = folder_or_skip("mitsuba") / "mi-cornell-box"
    references = tuple(read_exr(folder / name) for name in ("reference.exr", "reference2.exr"))
    agreement = compare(ours(load_json(folder / "scene.json"), 64, 8), references)
    assert agreement.agrees(tolerance=0.005), str(agreement)


def reduced(image, width, height):
    """A published picture box-averaged to another size (a divisor of its own)."""
    h, w, c = image.shape
    assert w % width == 0
    assert h % height == 0
    return image.reshape(height, h // height, width, w // width, c).mean(axis=(1, 3))


@pytest.mark.parametrize(
    ("name", "size", "samples", "max_depth", "mean", "cell"),
    [("cornell-box", (128, 128), 64, 30, 0.005, 0.02), ("veach-mis", (160, 90), 256, 2, 0.02, 0.04)],
)
def test_published_pictures(name, size, samples, max_depth, mean, cell):
    """Against Tungsten's images, as near as Mitsuba itself comes to them (see the scenes' own notes).

    Cells of an 8 × 6 grid within `cell` beyond three sigma of our noise, channel means within `mean`.
    """
    folder = folder_or_skip("mitsuba") / name
    expected = reduced(read_exr(folder / "TungstenRender.exr")[..., :3], *size)
    pair = ours(resized(load_xml(folder / "scene.xml"), *size), samples, max_depth)
    image = (pair[0].astype(float) + pair[1]) / 2
    assert np.abs(image.mean(axis=(0, 1)) / expected.mean(axis=(0, 1)) - 1).max() < mean
    ends = [np.linspace(0, n, k + 1).astype(int)[:-1] for n, k in zip(size[::-1], (6, 8), strict=True)]
    a0, a1, b = (cell_means(np.asarray(x, float), ends) for x in (*pair, expected))
    noise = np.sqrt(((a0 - a1) ** 2).mean()) / 2
    assert (np.abs((a0 + a1) / 2 - b) < cell * b + 3 * noise).all()


@pytest.mark.parametrize("name", DICTS)
def test_agrees_with_mitsuba(name):
    """The same dict rendered by both, box filter, the same depth."""
    pytest.importorskip("mitsuba")
    content, samples = DICTS[name]
    depth = content["integrator"]["max_depth"]
    theirs = tuple(rendered_by_mitsuba(content, samples, seed) for seed in (0, 1))
    agreement = compare(ours(content, samples, depth), theirs, grid=(8, 6))
    assert agreement.agrees(tolerance=0.005), str(agreement)
