"""Perlin's and Voronoi's lattices: every lane gets the same bits whatever lanes it comes with."""

import numpy as np
import pytest

from pt_engine.nodes import noise_nodes, perlin, voronoi
from pt_engine.nodes.hashes import hash_uints

FEW = 7


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
    has_grid = perlin.Grid.around(np.floor(np.stack(many))) is not None
    assert has_grid == (extent == 2)


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
    mask = np.uint32(perlin.GRADIENTS[dimension].shape[1] - 1)
    expected = hash_uints(*keys) & mask
    found = perlin._hashed([k.copy() for k in keys], perlin.Work())
    np.testing.assert_array_equal(found, expected)


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
        settings = voronoi.Settings("F1", "EUCLIDEAN", one, randomness, one)
        together = parts(getattr(voronoi, feature)(settings, many))
        for k in (0, 1, size - 1):
            there = settings._replace(randomness=randomness[k : k + 1] if randomness is own else one)
            alone = parts(getattr(voronoi, feature)(there, [p[k : k + 1] for p in many]))
            for a, b in zip(together, alone, strict=True):
                np.testing.assert_array_equal(a[..., k], b[..., 0])


def parts(found):
    """The arrays of an octave, or of a distance alone."""
    return [found] if isinstance(found, np.ndarray) else [found.distance, found.color, *found.position]


@pytest.mark.parametrize("point", [np.nan, np.inf, -np.inf, 3e38])
def test_a_point_beyond_all_cells_harms_no_other(point):
    """Distances stay finite, or as far as can be; the lanes beside it keep their values."""
    many = points(3, 30, size=10)
    one = np.ones(1, np.float32)
    settings = voronoi.Settings("F1", "EUCLIDEAN", one, one, one)
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
