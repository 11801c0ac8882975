"""The Image Texture gives what Cycles gives (the Cycles inside bpy), for every kind of image and look-up.

"Exact" is |ours − Cycles| ≤ 1e-4·(|Cycles| + 0.01) at every pixel; `support.image_cases` lists the images.
"""

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")
import numpy as np  # noqa: E402
from support import cycles_images, image_cases, image_files  # noqa: E402
from support.bpy_scenes import empty_scene  # noqa: E402
from support.cycles_images import Case  # noqa: E402
from support.tilted_sheets import TiltedSheets  # noqa: E402

pytestmark = pytest.mark.skipif(
    bpy.app.version < (5, 0, 0), reason="images follow Cycles 5: 4.5 keeps and associates texels otherwise"
)


def all_wrong(cases, frame=1, flat=(), **makers):
    """Descriptions of what differs, of cases that are unexpectedly of one colour; and the coverage."""
    found, coverage, unsupported = cycles_images.answers(cases, frame, **makers)
    lines = []
    for case, (theirs, ours) in zip(cases, found, strict=True):
        share, text = cycles_images.wrong(theirs, ours)
        if share > case.jumps:
            lines.append(f"{case.name}: {text}")
        if np.ptp(theirs) == 0 and case.name not in flat:
            lines.append(f"{case.name}: {theirs[:, 0]} everywhere")
    return lines, {entry.effect for entry in coverage if entry.effect}, unsupported


@pytest.fixture
def files(tmp_path):
    empty_scene()
    return image_cases.Files(tmp_path)


@pytest.mark.parametrize("kind", ["look_ups", "formats", "alpha_modes", "udims", "made"])
def test_images_are_those_of_cycles(kind, files):
    cases = list(getattr(image_cases, kind)(files))
    flat = [c.name for c in cases if "1×1" in c.name and "CLIP" not in c.name]
    flat += [c.name for c in cases if "BLANK" in c.name or ("grey alpha" in c.name)]
    lines, effects, _ = all_wrong(cases, flat=flat)
    assert not lines
    assert all("magenta" in effect for effect in effects)


def test_boxes_are_those_of_cycles(files):
    faces = TiltedSheets()
    lines, effects, _ = all_wrong(list(image_cases.boxes(files)), sheet=faces.sheet, lanes=faces.lanes)
    assert not lines
    assert not effects


SPACES = ["sRGB", "Linear Rec.709", "Non-Color", "Filmic Log", "AgX Log", "ACEScg", "Gamma 2.2 Encoded AP1"]


@pytest.mark.parametrize("names", [SPACES, pytest.param(None, marks=pytest.mark.slow, id="all")])
def test_colour_spaces_are_those_of_cycles(names, files):
    """OpenColorIO computes some curves fast and roughly: even its rounding of alpha is followed."""
    lines, effects, _ = all_wrong(list(image_cases.spaces(files, names or image_cases.all_spaces())))
    assert not lines
    assert not effects


def test_bad_images_look_as_in_cycles_and_are_named(files):
    flat = ("missing", "no image", "no image Alpha", "empty", "half a png", "half a exr")
    lines, effects, unsupported = all_wrong(list(image_cases.bad(files)), flat=flat)
    assert not lines
    for name in ("missing.png", "empty.png", "half.png", "half.exr", "no image is set"):
        assert any(name in effect and "magenta" in effect for effect in effects), name
    assert not unsupported  # said once


@pytest.mark.parametrize("frame", [5, 6, 40])
def test_a_sequence_shows_the_file_that_cycles_shows(frame, files, tmp_path):
    for number in range(1, 10):
        image_files.write(tmp_path / f"film{number:03}.png", image_files.pattern(4, 4, 3, number))

    def settings(start, length, offset, cyclic):
        def apply(node):
            node.image = image_cases.loaded(tmp_path / "film002.png")
            node.image.source, user = "SEQUENCE", node.image_user
            user.frame_start, user.frame_duration, user.frame_offset = start, length, offset
            user.use_cyclic = cyclic

        return {"user": apply}

    rows = [
        (1, 9, 0, False), (3, 4, 1, False), (3, 4, 1, True), (7, 3, 0, True), (7, 3, 2, False),
        (6, 3, 2, True), (1, 2, 3, True), (1, 0, 5, True), (1, 3, -2, False), (7, 3, 0, False),
    ]  # fmt: skip
    cases = [Case(f"{row}", None, settings(*row)) for row in rows]
    lines, _, _ = all_wrong(cases, frame, flat=[f"{row}" for row in rows])
    assert not lines
