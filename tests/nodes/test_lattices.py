"""Perlin's and Voronoi's lattices: every lane gets the same bits whatever lanes it comes with."""

import itertools

import numpy as np
import pytest

from pt_engine.core import memory
from pt_engine.nodes import grids, lattice, noise, noise_nodes, perlin, voronoi, voronoi_cells, voronoi_grids
from pt_engine.nodes.hashes import cell, hash_uints

FEW = 7
ALMOST_ONE = 1638.7255, 988  # where two cells' points are less than 0.007 from each other


def points(dimension, extent, size=3000):
    random = np.random.default_rng(dimension)
    return [
        (random.random(size, np.float32) - np.float32(0.5)) * np.float32(extent) for _ in range(dimension)
    ]


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
@pytest.mark.parametrize("extent", [2, 1e4, 3e6])
def test_perlin_noise_does_not_depend_on_the_batch(dimension, extent):
    """Many lanes in few cells look gradients up in a grid, others hash them: the same gradients."""
    many = points(dimension, extent)
    together = perlin.signed_noise(many)
    apart = [perlin.signed_noise([p[k : k + 1] for p in many])[0] for k in range(FEW)]
    np.testing.assert_array_equal(together[:FEW], apart)
    first, last = ([int(np.floor(end(p))) for p in many] for end in (np.min, np.max))
    assert (perlin_grids().around(first, last, len(many[0])) is not None) == (extent == 2)


def perlin_grids(most=grids.MOST):
    """Grids that know no place yet."""
    return grids.Grids(grids.Grid, most)


class NoGrids:
    """Every lane's corners are hashed."""

    @staticmethod
    def around(first, last, lanes):
        return None


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
def test_grids_of_other_lanes_give_the_same_bits(dimension, monkeypatch):
    """Bumps come back to where grids are, a millionth of a cell or ten cells beside them, or far away."""
    many = points(dimension, 4)
    many[-1][:100] = 1  # on lattice points
    monkeypatch.setattr(perlin, "GRIDS", kept := perlin_grids())
    for offset in (0, 1e-6, 1e-3, 0.3, 1, 10, 1e5, np.nan, 1e30):
        there = [p + np.float32(offset) for p in many]
        with monkeypatch.context() as plain, np.errstate(all="ignore"):
            found = perlin.signed_noise(there)
            plain.setattr(perlin, "GRIDS", NoGrids)
            np.testing.assert_array_equal(found.view(np.uint32), perlin.signed_noise(there).view(np.uint32))
    made = sum(place.grid is not None for place in kept._places.values())
    assert made >= 2


def test_a_grid_is_made_once_lanes_have_cost_as_much_and_kept_for_all_that_fit():
    """Ski rental: never more than twice the cost of the better way. A box that must grow starts anew."""
    kept, first, last = perlin_grids(most=60**3), [0, 0, 0], [39, 39, 39]  # 40³ corners
    lanes = int(40**3 / grids.DEAR / 3)
    assert [kept.around(first, last, lanes) is None for _ in range(4)] == [True, True, True, False]
    grid = kept.around(first, last, 1)
    assert kept.around([3, 0, 1], [38, 30, 33], 1) is grid
    assert kept.around([-1, 0, 0], last, 1) is None
    assert kept.around([-3, 0, 0], last, 3 * lanes) is None  # now with some room around it
    assert kept.around([-3, 0, 0], last, 3 * lanes) is not None
    assert kept.around([-20] * 3, [20] * 3, 3 * lanes) is None  # more than 60³ hold both
    assert kept.around([-20] * 3, [20] * 3, 3 * lanes) is not None


def test_only_so_many_grids_are_kept(monkeypatch):
    """Those that were asked for last."""
    monkeypatch.setattr(grids, "KEPT", 5 * 10**3 * 9)
    monkeypatch.setattr(grids, "PLACES", 7)
    kept = perlin_grids()
    for k in range(20):
        kept.around([100 * k] * 3, [100 * k + 9] * 3, 1000)
    assert [place.first[0] for place in kept._places.values()] == [1500, 1600, 1700, 1800, 1900]
    for k in range(20):
        kept.around([100 * k] * 3, [100 * k + 40] * 3, 1)
    assert len(kept._places) == 7


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
def test_blocks_of_perlin_noise_overlap_and_share_buffers(dimension):
    """More lanes than a block holds, in buffers that have seen others: as if each had been alone."""
    size = (perlin.BLOCK >> dimension) * 2 + 3
    many = points(dimension, 1e4, size)
    perlin.signed_noise(points(dimension, 3e6, size))
    together = perlin.signed_noise(many)
    for k in (0, size // 3, size - 4, size - 1):
        np.testing.assert_array_equal(together[k], perlin.signed_noise([p[k : k + 1] for p in many])[0])


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
def test_the_largest_block_has_room(dimension):
    """Whichever its axes are."""
    lanes = perlin.BLOCK >> dimension
    for count in range(1, dimension + 1):
        for active in itertools.combinations(range(dimension), count):
            for still in ((), active[:1], active):
                perlin.Room().block(dimension, active, still, lanes)


@pytest.mark.parametrize("size", [37, 3000])
@pytest.mark.parametrize("axis", range(4))
def test_an_axis_on_which_all_lanes_are_at_one_place(axis, size):
    """Gives what it gives where one more lane lies elsewhere on it."""
    for dimension in range(axis + 1, 5):
        many = points(dimension, 30, size)
        many[axis] = np.full(size, 7.3125, np.float32)
        apart = [np.append(p, np.float32(q)) for p, q in zip(many, (0.3, 0.4, 0.5, 0.6), strict=False)]
        np.testing.assert_array_equal(perlin.signed_noise(many), perlin.signed_noise(apart)[:-1])


@pytest.mark.parametrize("size", [1, 50, 3000])
def test_octaves_together_are_octaves_one_by_one(size):
    """Noise of p, λp, λ²p ...: few lanes go several octaves at a time."""
    many, lacunarity = points(3, 4, size), np.linspace(1.5, 2.5, size, dtype=np.float32)
    scale = np.ones(1, np.float32)
    for found in noise.scaled_noises(many, lacunarity, 16):
        np.testing.assert_array_equal(found, perlin.signed_noise([p * scale for p in many]))
        scale = scale * lacunarity


def test_the_period_is_exact():
    """p − 100000 trunc(p / 100000) without a rounding, as C's fmod has it, up to where numbers are coarse."""
    p = np.nextafter(np.float32(1e5) * np.arange(-9, 10, dtype=np.float32), np.float32(np.inf))
    p = np.concatenate([p, -p, np.geomspace(1, 9e5, 1000, dtype=np.float32)])
    np.testing.assert_array_equal(perlin._periodic(p), np.fmod(p, np.float32(1e5)))


@pytest.mark.parametrize("far", [9.95e4, 1.234e5, -3.7e5, 9.9999e5, 5.5e6, -4.99e8, 6e8])
def test_points_within_one_period_are_moved_into_the_first_together(far):
    """By what each alone is moved by, to the bit, where no multiple of the period is among them."""
    many = [p + np.float32(far) for p in points(3, 100, size=500)]
    ends = [(float(p.min()), float(p.max())) for p in many]
    shift = perlin._common_shift(ends)
    assert (shift is None) == (abs(far) > 5e8 or np.ptp(np.trunc(np.array(ends) / 1e5)) != 0)
    alone = perlin._periodic(np.stack(many))
    if shift is not None:
        np.testing.assert_array_equal(perlin._shifted(np.stack(many), shift), alone)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("extent", [2, 1e4])
def test_noise_on_a_lattice_plane_needs_only_the_corners_there(axis, extent):
    """A uv map's z is 0. A lane off the plane makes all corners count, and the others stay as they were."""
    many = points(3, extent)
    many[axis][:] = np.round(many[axis][0])
    flat = perlin.signed_noise(many)
    many[axis][-1] += np.float32(0.5)
    np.testing.assert_array_equal(perlin.signed_noise(many)[:-1].view(np.uint32), flat[:-1].view(np.uint32))


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_the_shortened_hash_has_the_low_bits_of_the_whole(dimension):
    random = np.random.default_rng(0)
    keys = [random.integers(0, 2**32, 1000, np.uint32) for _ in range(dimension)]
    cells = np.stack(keys)
    room = memory.Memory(np.empty(1 << 18, np.uint8))
    work = room.array((4, *(2,) * dimension, 1000), np.uint32)
    hashes = lattice.Hashes(dimension, tuple(range(dimension)), work, room)
    for corner in itertools.product((0, 1), repeat=dimension):
        whole = hash_uints(*(key + np.uint32(step) for key, step in zip(keys, corner, strict=True)))
        found = hashes.of_corners(cells)[corner]
        np.testing.assert_array_equal(found & np.uint32(31), whole & np.uint32(31))


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
@pytest.mark.parametrize("feature", ["f1", "f2", "edge_distance", "sphere_radius"])
def test_voronoi_does_not_depend_on_the_batch(dimension, feature):
    """Lanes are worked on in blocks, here more than one, each with a randomness of its own."""
    many = points(dimension, 30)
    size = voronoi.BLOCK // 3**dimension + 5 if dimension > 2 else len(many[0])
    many = [np.resize(p, size) for p in many]
    one = np.ones(1, np.float32)
    own = np.linspace(0, 1, size, dtype=np.float32)
    for randomness in (one, own):
        settings = voronoi_cells.Settings("F1", "EUCLIDEAN", one, randomness, one)
        together = parts(getattr(voronoi, feature)(settings, many))
        for k in (0, 1, size - 1):
            there = settings._replace(randomness=randomness[k : k + 1] if randomness is own else one)
            alone = parts(getattr(voronoi, feature)(there, [p[k : k + 1] for p in many]))
            for a, b in zip(together, alone, strict=True):
                np.testing.assert_array_equal(a[..., k], b[..., 0])


@pytest.mark.parametrize("dimension", [2, 3, 4])
@pytest.mark.parametrize("feature", ["f1", "f2", "smooth_f1", "edge_distance", "sphere_radius"])
@pytest.mark.parametrize("randomness", [0.3, 1])
def test_voronoi_grids_give_the_same_bits(dimension, feature, randomness, monkeypatch):
    """Many lanes in few cells look points up, to the last cell that any feature looks at; or hash them."""
    one = np.ones(1, np.float32)
    settings = voronoi_cells.Settings("F1", "EUCLIDEAN", one, np.float32(randomness) * one, one)
    find, there = getattr(voronoi, feature), points(dimension, 2)
    kept = grids.Grids(voronoi_grids.CellGrid, voronoi_grids.MOST)
    monkeypatch.setattr(voronoi_grids, "GRIDS", kept)
    for offset in (0, 0.3, -1e5, np.nan):
        for p in there:
            p += np.float32(offset)
        with monkeypatch.context() as plain, np.errstate(all="ignore"):
            known = parts(find(settings, there))
            plain.setattr(voronoi_grids, "GRIDS", NoGrids)
            for a, b in zip(known, parts(find(settings, there)), strict=True):
                np.testing.assert_array_equal(a.view(np.uint32), b.view(np.uint32))
    assert sum(place.grid is not None for place in kept._places.values()) >= 2


def test_a_point_upon_another_has_no_edge_with_it():
    """Without randomness points are the cells' corners: half a step to the edge, whoever else is there."""
    one, steps = np.ones(1, np.float32), np.linspace(-0.49, 0.49, 600, dtype=np.float32)
    settings = voronoi_cells.Settings("F1", "EUCLIDEAN", one, 0 * one, one)
    edge = voronoi.edge_distance(settings, [steps + np.float32(3), 0 * steps])
    np.testing.assert_allclose(edge, 0.5 - np.abs(steps), atol=1e-6)
    edge = voronoi.edge_distance(settings, [np.full(600, np.nan, np.float32), 0 * steps])
    np.testing.assert_array_equal(edge, voronoi_cells.FAR)


def test_there_is_no_border_between_points_that_are_almost_one():
    """Against the definition, of the cells around: half the way to each point that is not within 0.01."""
    random, one = np.random.default_rng(0), np.ones(1, np.float32)
    lanes = np.array(ALMOST_ONE)[:, None] + random.normal(scale=0.2, size=(2, 1000))
    lanes = lanes.astype(np.float32)
    settings = voronoi_cells.Settings("F1", "EUCLIDEAN", one, one, one)
    steps = np.array([(a, b) for b in (-1, 0, 1) for a in (-1, 0, 1)], np.int32).T[:, :, None]
    own = np.floor(lanes)[:, None]
    around = np.array(cell(*(own.astype(np.int32) + steps))) + steps.astype(np.float32)
    ways = around - (lanes[:, None] - own)
    nearest = np.take_along_axis(ways, (ways**2).sum(0).argmin(0)[None, None], axis=1)
    apart = ((ways - nearest) ** 2).sum(0)
    borders = ((ways + nearest) * (ways - nearest)).sum(0) / (2 * np.sqrt(np.maximum(apart, 1e-30)))
    edge = np.where(apart > 1e-4, borders, np.inf).min(0)
    assert ((apart > 0) & (apart <= 1e-4)).any(axis=0).mean() > 0.5
    np.testing.assert_allclose(voronoi.edge_distance(settings, list(lanes)), edge, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
@pytest.mark.parametrize("metric", ["EUCLIDEAN", "MINKOWSKI"])
@pytest.mark.parametrize("randomness", [0, 1])
def test_the_distance_alone_is_the_distance_of_the_nearest_points(dimension, metric, randomness):
    """F1 and F2 where colour and place are not asked for; without randomness, of points equally far."""
    many, one = points(dimension, 30), np.ones(1, np.float32)
    many = many if randomness else [np.round(2 * p) / 2 for p in many]
    for feature, whole in (("F1", voronoi.f1), ("F2", voronoi.f2)):
        settings = voronoi_cells.Settings(feature, metric, 0.5 * one, randomness * one, one)
        np.testing.assert_array_equal(voronoi.distances(settings, many), whole(settings, many).distance)


def parts(found):
    """The arrays of an octave, or of a distance alone."""
    return [found] if isinstance(found, np.ndarray) else [found.distance, found.color, *found.position]


@pytest.mark.parametrize("point", [np.nan, np.inf, -np.inf, 3e38])
def test_a_point_beyond_all_cells_harms_no_other(point):
    """Distances stay finite, or as far as can be; the lanes beside it keep their values."""
    many = points(3, 30, size=10)
    one = np.ones(1, np.float32)
    settings = voronoi_cells.Settings("F1", "EUCLIDEAN", one, one, one)
    with np.errstate(all="ignore"):
        clean = voronoi.f2(settings, many).distance
        many[1][4] = point
        found = voronoi.f2(settings, many).distance
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(np.delete(found, 4), np.delete(clean, 4))


@pytest.mark.parametrize("varies", [False, True])
def test_few_lanes_take_another_way_to_the_same_color(varies, monkeypatch):
    """All three channels at once, or one after the other."""
    vector = np.stack(points(3, 9, size=50))
    one = np.ones(1, np.float32)
    detail = np.linspace(0, 3, 50, dtype=np.float32) if varies else 2 * one
    inputs = (vector, one, 2 * one, 0.3 * one, detail, 0.5 * one, 2 * one, 0 * one, one)
    expected = noise_nodes.noise_color(3, "FBM", True, *inputs)
    monkeypatch.setattr(noise_nodes, "FEW", 0)
    np.testing.assert_array_equal(noise_nodes.noise_color(3, "FBM", True, *inputs), expected)
