"""The cases of `test_images_against_cycles`: every kind of image and look-up that an Image Texture knows."""

import itertools

import bpy
import numpy as np
from support import image_files
from support.cycles_images import Case

EXTENSIONS = ("REPEAT", "EXTEND", "CLIP", "MIRROR")
FILTERS = ("Linear", "Closest", "Cubic", "Smart")
TILES = (1001, 1002, 1005, 1011, 1012, 1021)
SIZES = ((5, 6), (9, 4), (1, 1), (16, 3), (2, 2), (64, 64))


class Files:
    """Makes image files in a folder and Blender images of them; equal files are written once."""

    def __init__(self, folder):
        self.folder = folder

    def image(self, name, shape, form="uint8", space="", alpha="", pack=False, high=1.0):
        """A function that makes the Blender image of a file of random values."""

        def make():
            path = self.folder / f"{form}{'x'.join(map(str, shape))}{name}"
            if not path.exists():
                image_files.write(path, image_files.pattern(*shape, high=high), form)
            return loaded(path, space, alpha, pack)

        return make

    def tiles(self, name, token="<UDIM>", pack=False, missing=(), broken=()):
        """A function that makes a UDIM of tiles of different sizes, some of which may be bad."""

        def make():
            paths = {number: self.folder / f"{name}.{label(token, number)}.png" for number in TILES}
            for (number, path), size in zip(paths.items(), SIZES, strict=True):
                image_files.write(path, image_files.pattern(*size, 4, seed=number))
                if number in broken:
                    path.write_bytes(b"no image")
            image = loaded(paths[1001])
            image.source, image.filepath = "TILED", str(self.folder / f"{name}.{token}.png")
            for number in set(TILES) - {tile.number for tile in image.tiles}:
                image.tiles.new(number)
            for number in missing:
                paths[number].unlink()
            if pack:
                image.pack()
                for path in paths.values():
                    path.unlink()
            return image

        return make

    def damaged(self, name, shape, form, damage):
        """A function that makes an image whose file is damaged by `damage(path)` after it was loaded."""

        def make():
            path = image_files.write(self.folder / name, image_files.pattern(*shape), form)
            image = loaded(path)
            damage(path)
            return image

        return make

    def with_nan(self, name, channels, space, pack=False):
        """A function that makes an image with texels that are no numbers, or infinite."""

        def make():
            values = image_files.pattern(6, 6, channels)
            values[1, 2, 0], values[3, 3, -1], values[5, 0, 0] = np.nan, np.inf, -np.inf
            return loaded(image_files.write(self.folder / name, values, "float"), space, "", pack)

        return make


def loaded(path, space="", alpha="", pack=False):
    """The Blender image of a file."""
    image = bpy.data.images.load(str(path), check_existing=False)
    if space:
        image.colorspace_settings.name = space
    if alpha:
        image.alpha_mode = alpha
    if pack:
        image.pack()
    return image


def label(token, number):
    """What stands for a tile in its file's name."""
    column, row = (number - 1001) % 10, (number - 1001) // 10
    return str(number) if token == "<UDIM>" else f"u{column + 1}_v{row + 1}"


def generated(kind, is_float):
    """A function that makes a generated image."""

    def make():
        image = bpy.data.images.new("Made", 64, 32, alpha=True, float_buffer=is_float)
        image.generated_type, image.generated_color = kind, (0.2, 0.5, 0.7, 0.5)
        return image

    return make


def generated_tiles(is_float):
    """A function that makes a UDIM of two generated tiles."""

    def make():
        image = bpy.data.images.new("Made", 8, 8, alpha=True, float_buffer=is_float, tiled=True)
        image.tiles.new(1002)
        for k in range(2):
            image.tiles.active_index = k
            color = (0.1 + 0.2 * k, 0.5, 0.9, 0.5)
            with bpy.context.temp_override(edit_image=image):
                bpy.ops.image.tile_fill(color=color, width=9, height=7, float=is_float, alpha=True)
        return image

    return make


def look_ups(files):
    """All filters, extensions and projections."""
    for projection, extension, interpolation in itertools.product(
        ("FLAT", "SPHERE", "TUBE"), EXTENSIONS, FILTERS
    ):
        settings = {"projection": projection, "extension": extension, "interpolation": interpolation}
        name = " ".join(settings.values())
        yield Case(name, files.image(".png", (7, 5, 4)), settings)
        if projection == "FLAT":
            yield Case(f"{name} 1×1", files.image(".png", (1, 1, 3)), settings)
            yield Case(f"{name} 8×1", files.image(".png", (1, 8, 4)), settings)
            yield Case(f"{name} grey alpha", files.image(".png", (6, 7, 1)), settings, "Alpha")


def boxes(files):
    """The box projection: sharp and blended, with all filters and extensions."""
    for blend, extension, interpolation in itertools.product((0.0, 0.3, 1.0), EXTENSIONS, FILTERS):
        settings = {"projection": "BOX", "extension": extension, "interpolation": interpolation}
        name = f"BOX {blend} {extension} {interpolation}"
        yield Case(name, files.image(".png", (9, 6, 4)), settings | {"projection_blend": blend}, both=True)
    yield Case("BOX UDIM", files.tiles("box"), {"projection": "BOX", "projection_blend": 0.5})


FORMATS = (
    (".png", "uint8", (1, 2, 3, 4)), (".png", "uint16", (1, 3, 4)), (".tif", "uint8", (1, 4)),
    (".tif", "uint16", (3, 4)), (".tif", "float", (1, 4)), (".tif", "half", (4,)), (".jpg", "uint8", (1, 3)),
    (".exr", "half", (1, 3, 4)), (".exr", "float", (1, 4, 5)), (".hdr", "float", (3,)),
    (".webp", "uint8", (3, 4)), (".bmp", "uint8", (3, 4)), (".tga", "uint8", (3, 4)),
)  # fmt: skip


def formats(files):
    """File formats and number formats, from disk and packed."""
    for suffix, form, counts in FORMATS:
        for channels, pack in itertools.product(counts, (False, True)):
            if pack and channels == 5:
                continue
            high = 3.0 if suffix in (".exr", ".hdr") else 1.0
            image = files.image(suffix, (6, 7, channels), form, pack=pack, high=high)
            name = f"{suffix} {form} {channels} {'packed' if pack else ''}"
            yield Case(name, image, {}, both=True)


def alpha_modes(files):
    """What alpha means, by format and colour space."""
    for alpha, (suffix, form), space, pack in itertools.product(
        ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"),
        ((".png", "uint8"), (".png", "uint16"), (".exr", "half")),
        ("sRGB", "Non-Color", "ACEScct"),
        (False, True),
    ):
        image = files.image(suffix, (6, 7, 4), form, space, alpha, pack)
        name = f"{alpha} {suffix} {form} {space} {'packed' if pack else ''}"
        yield Case(name, image, {}, both=True)
        if alpha == "STRAIGHT":
            yield Case(f"{name} Color", image, {})


def all_spaces():
    """Every colour space of Blender's config."""
    properties = bpy.types.ColorManagedInputColorspaceSettings.bl_rna.properties
    return [item.identifier for item in properties["name"].enum_items]


def spaces(files, names):
    """Bytes and floats in colour spaces."""
    for name in names:
        yield Case(f"{name} bytes", files.image(".png", (6, 7, 4), space=name), {})
        yield Case(f"{name} floats", files.image(".exr", (6, 7, 4), "float", name), {})


def udims(files):
    """Tiles of different sizes, their extensions, and bad ones."""
    wide = (-1.5, 5.5)
    for extension in EXTENSIONS:
        yield Case(f"UDIM {extension}", files.tiles("udim"), {"extension": extension}, bounds=wide)
    yield Case("UDIM UVTILE", files.tiles("uvtile", "<UVTILE>"), {"interpolation": "Closest"}, bounds=wide)
    yield Case("UDIM packed", files.tiles("packed", pack=True), {}, both=True, bounds=wide)
    yield Case("UDIM missing", files.tiles("missing", missing=(1002,)), {}, both=True, bounds=(-0.5, 2.5))
    yield Case("UDIM broken", files.tiles("broken", broken=(1001, 1011)), {}, bounds=(-0.5, 2.5))
    for is_float in (False, True):
        yield Case(f"UDIM made {is_float}", generated_tiles(is_float), {}, both=True, bounds=(-0.5, 2.5))


def made(files):
    """Generated images."""
    for kind, is_float in itertools.product(("BLANK", "UV_GRID", "COLOR_GRID"), (False, True)):
        yield Case(f"generated {kind} {is_float}", generated(kind, is_float), {}, both=True)


def bad(files):
    """Files that are missing, broken or full of what is no number."""

    def cut(path):
        content = path.read_bytes()
        path.write_bytes(content[: len(content) // 2])

    yield Case("no image", None, {})
    yield Case("no image Alpha", None, {}, "Alpha")
    yield Case("missing", files.damaged("missing.png", (4, 4, 4), "uint8", lambda path: path.unlink()), {})
    yield Case(
        "empty", files.damaged("empty.png", (4, 4, 4), "uint8", lambda path: path.write_bytes(b"")), {}
    )
    for suffix, channels, form in (("png", 4, "uint8"), ("jpg", 3, "uint8"), ("exr", 4, "float")):
        yield Case(f"half a {suffix}", files.damaged(f"half.{suffix}", (64, 64, channels), form, cut), {})
    for channels, space in ((1, "Linear Rec.709"), (4, "Linear Rec.709"), (4, "ACEScg")):
        yield Case(
            f"NaN {channels} {space}", files.with_nan(f"nan{channels}{space}.exr", channels, space), {}
        )
    yield Case("NaN packed", files.with_nan("nan.exr", 4, "Linear Rec.709", pack=True), {}, "Alpha")
