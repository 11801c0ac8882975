"""Images that do not fit in memory, UDIM tiles, and what the store tells of itself."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

oiio = pytest.importorskip("OpenImageIO")
from support import image_files  # noqa: E402

from pt_engine.scene.snapshot import ImageData  # noqa: E402
from pt_engine.textures import lookup  # noqa: E402
from pt_engine.textures.images import TextureStore  # noqa: E402
from pt_engine.textures.memory import pools  # noqa: E402


def test_tiles_of_a_small_pool_are_the_same_texels(tmp_path):
    """16k images do not fit; here are small ones that do not fit in a smaller limit."""
    rng = np.random.default_rng(0)
    u, v = rng.uniform(-1.5, 2.5, (2, 5000)).astype(np.float32)
    shapes = (
        ("a.png", (300, 270, 4), "uint8"),
        ("b.png", (257, 450, 3), "uint16"),
        ("c.exr", (400, 300, 4), "half"),
        ("d.tif", (330, 257, 1), "float"),
        ("e.png", (300, 200, 1), "uint8"),
        ("f.tif", (300, 300, 3), "float"),
    )
    images = []
    for name, shape, form in shapes:
        path = image_files.write(tmp_path / name, image_files.pattern(*shape), form)
        images.append(ImageData(name, encoded=np.fromfile(path, np.uint8), suffix=path.suffix))
    whole, tiled = TextureStore(images), TextureStore(images, limit=100_000)
    for index in range(len(images)):
        for interpolation in ("Closest", "Linear", "Cubic"):
            for extension in lookup.WRAPS:
                a = whole.texture(index, interpolation, extension, True).sample(u, v)
                b = tiled.texture(index, interpolation, extension, True).sample(u, v)
                for one, other in zip(a, b, strict=True):
                    np.testing.assert_array_equal(one, other)
    numbers = tiled.statistics()
    assert numbers["tiled"] == 6
    assert numbers["tile_evictions"] > 0
    assert numbers["bytes"] < numbers["full_bytes"]


def test_threads_share_a_pool(tmp_path):
    """Tiles that one thread throws out are not those another is looking at."""
    path = image_files.write(tmp_path / "shared.png", image_files.pattern(500, 500, 4))
    image = ImageData("shared", encoded=np.fromfile(path, np.uint8), suffix=".png")
    u, v = np.random.default_rng(0).random((2, 40, 3000), dtype=np.float32)
    whole = TextureStore([image]).texture(0, "Linear", "REPEAT", False)
    tiled = TextureStore([image], limit=300_000).texture(0, "Linear", "REPEAT", False)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(tiled.sample, u, v))
    for k, (color, _) in enumerate(found):
        np.testing.assert_array_equal(color, whole.sample(u[k], v[k])[0])


def test_mip_maps_are_named(tmp_path):
    path = str(tmp_path / "mip.tx")
    source = oiio.ImageBuf(image_files.pattern(128, 128, 3))
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, source, path)
    image = ImageData("mip", encoded=np.fromfile(path, np.uint8), suffix=".tx")
    (note,) = TextureStore([image]).texture(0, "Linear", "REPEAT", False).notes
    assert "mip" in note


def pixels(color, size=(2, 2), name=""):
    return ImageData(name, "Linear Rec.709", "STRAIGHT", pixels=np.full((*size, 4), color, np.float32))


def udim_store():
    """Tiles 1001 (red), 1012 (green) and 1002, which is missing."""
    tiles = ((1001, 0), (1012, 1), (1002, 2))
    gone = ImageData("gone", problem="no such file")
    udim = ImageData("udim", tiles=tiles)
    return TextureStore([pixels((1, 0, 0, 1)), pixels((0, 1, 0, 1), (3, 1)), gone, udim])


def test_lanes_look_into_their_own_tile():
    texture = udim_store().texture(3, "Linear", "REPEAT", True)
    where = np.array(
        [[0.5, 1.5, 1.5, 9.5, 10.5, -1.5, 0.5, np.nan], [0.5, 1.5, 0.5, 7.5, 0.5, 0.5, 1e9, 0.5]]
    )
    color, alpha = texture.sample(*where.astype(np.float32))
    red, green, magenta = (1, 0, 0), (0, 1, 0), (1, 0, 1)
    np.testing.assert_allclose(color.T, [red, green, *[magenta] * 6], atol=1e-6)
    np.testing.assert_array_equal(alpha, 1)
    assert color.dtype == alpha.dtype == np.float32
    (note,) = texture.notes
    assert "gone" in note
    assert "1002" in note


def test_no_lane_of_a_udim_depends_on_another():
    texture = udim_store().texture(3, "Cubic", "MIRROR", True)
    u, v = np.random.default_rng(0).uniform(-0.9, 2.5, (2, 300)).astype(np.float32)
    together = texture.sample(u, v)[0]
    alone = [texture.sample(u[k : k + 1], v[k : k + 1])[0] for k in range(300)]
    np.testing.assert_array_equal(together, np.concatenate(alone, axis=1))


def test_a_box_sees_the_first_tile_only():
    first = udim_store().texture(3, "Linear", "REPEAT", False, first_tile=True)
    color, _ = first.sample(np.array([0.5, 1.5], np.float32), np.array([0.5, 1.5], np.float32))
    np.testing.assert_allclose(color.T, [(1, 0, 0), (1, 0, 1)], atol=1e-6)


def test_small_images_stay_whole_and_large_ones_share_the_rest():
    """Sizes 10, 20, 100, 300 in 100: 10 and 20 are whole (≤ 50), 70 are left: 100/400 and 300/400 of it."""
    assert pools({0: 10, 1: 300, 2: 20, 3: 100}, 100) == {3: 17, 1: 52}
    assert pools({0: 10, 1: 300}, 310) == {}
    assert pools({0: 10, 1: 300}, 0) == {}


def test_the_store_counts_what_it_holds():
    store = TextureStore([pixels((1, 0, 0, 1)), pixels((0.5, 0.5, 0.5, 1)), ImageData("gone")])
    for index in (0, 1):
        store.texture(index, "Linear", "REPEAT", False)
        store.texture(index, "Closest", "CLIP", False)
    with pytest.raises(Exception, match="gone"):
        store.texture(2, "Linear", "REPEAT", False)
    # 4 texels: of 16 bytes, and of 4 where all are opaque greys
    assert store.statistics() == {
        "count": 2,
        "missing": 1,
        "bytes": 64 + 16,
        "limit_bytes": 0,
        "full_bytes": 64 + 16,
        "tiled": 0,
        "tile_reads": 0,
        "tile_evictions": 0,
    }
