"""Units of work: together they are the render, each sample of each pixel once."""

from __future__ import annotations

from itertools import cycle, islice

import numpy as np
import pytest

from pt_engine.render.schedule import LARGEST_PASS, morton_order, units
from pt_engine.render.settings import RenderSettings

SIZES = [(1, 1), (1, 7), (5, 1), (16, 16), (23, 17), (3, 100), (65, 2)]


def plan(width, height, **more):
    """The units of a render, and what they render from."""
    settings = RenderSettings(width, height, **more)
    x0, y0, x1, y1 = settings.window
    return list(units(settings, morton_order(x1 - x0, y1 - y0))), (x1 - x0) * (y1 - y0)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("samples", [1, 2, 7, 64, 100])
@pytest.mark.parametrize("lanes", [1, 3, 64, 1 << 16])
def test_every_sample_of_every_pixel_is_rendered_once(size, samples, lanes):
    work, pixels = plan(*size, samples=samples, lanes=lanes, first_sample=5)
    done = np.zeros((pixels, samples), int)
    for unit in work:
        done[unit.pixels, unit.first - 5 : unit.first - 5 + unit.spp] += 1
    assert (done == 1).all()


def test_units_that_shrink_render_the_same():
    """However many lanes a unit may have at the moment, down to one."""
    settings, sizes = RenderSettings(23, 17, samples=20, lanes=500), cycle((500, 90, 7, 1, 0, 1000))
    done = np.zeros((23 * 17, 20), int)
    for unit in units(settings, morton_order(23, 17), in_time=lambda: next(sizes)):
        assert len(unit.pixels) * unit.spp <= 500
        done[unit.pixels, unit.first : unit.first + unit.spp] += 1
    assert (done == 1).all()


@pytest.mark.parametrize("border", [(0, 0, 23, 17), (3, 2, 4, 3), (5, 0, 23, 17), (0, 16, 23, 17)])
def test_a_border_is_rendered_whole(border):
    work, pixels = plan(23, 17, border=border, samples=3, lanes=50)
    x0, y0, x1, y1 = border
    assert pixels == (x1 - x0) * (y1 - y0)
    assert sorted(np.concatenate([u.pixels for u in work if u.first == 0])) == list(range(pixels))


@pytest.mark.parametrize("lanes", [1, 2, 3, 5, 8, 13, 64, 1000])
def test_no_unit_is_larger_than_a_wavefront(lanes):
    """Its memory is what `lanes` promises."""
    for pixels in range(1, 40):
        work, _ = plan(pixels, 1, samples=20, lanes=lanes)
        assert max(len(u.pixels) * u.spp for u in work) <= lanes


def test_the_first_picture_comes_soon_and_passes_grow():
    """Pass after pass, each over all pixels: 1, 1, 2, 4, 8, 16, 16 … samples."""
    work, pixels = plan(32, 32, samples=64, lanes=300)
    counts: dict[int, int] = {}
    for unit in work:
        counts.setdefault(unit.first, unit.spp)
        assert counts[unit.first] == unit.spp
    assert list(counts.values()) == [1, 1, 2, 4, 8, *[16] * 3]
    assert list(counts) == sorted(counts)
    assert max(counts.values()) == LARGEST_PASS
    starts = [u.first for u in work]
    assert starts == sorted(starts)  # no pass begins before the one before is handed out
    assert sum(len(u.pixels) for u in work if u.first == 0) == pixels


def test_few_units_where_few_do():
    """A picture that fits a wavefront is one unit per pass."""
    work, _ = plan(32, 32, samples=64, lanes=1 << 16)
    assert len(work) == 8


def test_without_a_sample_limit_there_is_no_end():
    settings = RenderSettings(4, 4, samples=0, first_sample=9)
    first = 9
    for unit in islice(units(settings, morton_order(4, 4)), 1000):
        assert unit.first == first
        first += unit.spp


@pytest.mark.parametrize("size", [*SIZES, (300, 5), (1, 70_000)])
def test_morton_order_is_a_permutation(size):
    order = morton_order(*size)
    assert order.dtype == np.int32
    assert np.array_equal(np.sort(order), np.arange(size[0] * size[1]))


def test_morton_order_is_the_z_curve():
    """Each aligned 2ᵏ × 2ᵏ block of a square is one run."""
    order = morton_order(16, 16)
    y, x = np.divmod(order, 16)
    assert list(zip(x[:4], y[:4], strict=True)) == [(0, 0), (1, 0), (0, 1), (1, 1)]
    for size in (2, 4, 8):
        blocks = order.reshape(-1, size * size)
        y, x = np.divmod(blocks, 16)
        assert (np.ptp(x, axis=1) == size - 1).all()
        assert (np.ptp(y, axis=1) == size - 1).all()


def test_runs_of_the_order_are_compact():
    """What coherence is for: 256 consecutive pixels span few rows and columns, in any image."""
    for width, height in ((200, 120), (1000, 40)):
        order = morton_order(width, height)[: width * height // 256 * 256].reshape(-1, 256)
        y, x = np.divmod(order, width)
        extent = np.median(np.maximum(np.ptp(x, axis=1), np.ptp(y, axis=1)))
        assert extent <= 32  # scanlines would give 255
