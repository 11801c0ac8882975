"""Every input of Principled against Cycles at the corners of its range, all at once: what it scatters in all.

Rows of a sheet draw each input from its lowest, default, middle and highest values; columns are angles. Both
sides are means of some thousand samples per pixel, which leave 0.4 % of noise but where a bright lobe is
rarely chosen; hence 1 % for 95 of 100 values, 10 % for the rest, and 0.1 % for the mean of all. (With eight
times as many samples all are within 0.7 %.) Sheen is tested elsewhere; subsurface scattering in solids
is not Cycles'.

Two ranges are left out, as Cycles errs there. Its thin walls of an index below 1 read memory that nothing has
written where light is totally reflected. And up to a roughness of about 0.05 it finds D(m) from 1 − cos²θm,
which has no digits left: where two such lobes share a material, or one and a transparency, what they scatter
in all jumps by half, and is back at its value for a mirror.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.furnaces import by_cycles_and_us, material, sheet  # noqa: E402

from pt_engine.nodes.coverage import EXACT  # noqa: E402
from pt_engine.nodes.shaders import MORE_LIGHT_IN_CYCLES  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="4.5 has other inputs")

COSINES = np.linspace(0.1, 1.0, 8)
ROWS = 12
CORNERS = {
    "Metallic": (0, 0, 0.5, 1),
    "Roughness": (0, 0.2, 0.5, 1),
    "IOR": (1, 1.3, 1.5, 2.5),
    "Alpha": (0, 0.5, 1, 1),
    "Diffuse Roughness": (0, 0.3, 1),
    "Specular IOR Level": (0, 0.25, 0.5, 1),
    "Anisotropic": (0, 0.5, 1),
    "Anisotropic Rotation": (0, 0.25, 0.6, 1),
    "Transmission Weight": (0, 0, 0.5, 1),
    "Coat Weight": (0, 0, 0.5, 1),
    "Coat Roughness": (0, 0.1, 0.5, 1),
    "Coat IOR": (1, 1.2, 1.5, 2),
}
COLORS = ("Base Color", "Specular Tint", "Coat Tint")
WALLS = {"Thin Wall": (1,), "Subsurface Weight": (0, 0.5, 1), "Subsurface Anisotropy": (-1, 0, 0.4, 1)}
FILMS = {"Thin Film Thickness": (0, 0.5, 200, 500, 1500), "Thin Film IOR": (1, 1.33, 2)}
DENSE = {"IOR": (0.6, 0.9)}


def drawn(seed, corners):
    """Sheet and links for inputs drawn from their corners: numbers three to an attribute, colours one."""
    rng = np.random.default_rng(seed)
    axes, links = {}, {}
    names = list(corners)
    for first in range(0, len(names), 3):
        group, key = names[first : first + 3], f"N{first}"
        columns = [rng.choice(np.array(corners[name], float), ROWS) for name in group]
        axes[key] = np.stack([*columns, *[np.zeros(ROWS)] * (3 - len(group))], axis=1)
        links |= {name: f"{key}.{axis}" for name, axis in zip(group, "xyz", strict=False)}
    for key, name in zip("ABC", COLORS, strict=True):
        axes[key], links[name] = rng.choice([0, 0.25, 0.7, 1.0], (ROWS, 3)), key
    axes["T"], links["Tangent"] = rng.normal(size=(ROWS, 3)), "T"
    return sheet(COSINES, **axes), links


@pytest.mark.parametrize(
    ("corners", "settings"),
    [
        (CORNERS, {}),
        (CORNERS, {"distribution": "GGX"}),
        (CORNERS | DENSE, {}),
        (CORNERS | FILMS, {}),
        (CORNERS | WALLS | FILMS, {}),
    ],
    ids=["multiscatter", "single", "into air", "films", "walls with films"],
)
def test_corners_scatter_as_much_as_in_cycles(corners, settings, tmp_path):
    shape, links = drawn(len(corners), corners)
    if "Thin Wall" in links:
        links["Thin Wall"] = True
    made = lambda: material("BsdfPrincipled", links, **settings)  # noqa: E731
    theirs, ours, coverage = by_cycles_and_us(shape, made, 1024, tmp_path, points=2048)
    error = np.abs(ours - theirs) / (theirs + 0.05)
    assert np.quantile(error, 0.95) <= 0.01
    assert error.max() <= 0.1
    np.testing.assert_allclose(ours.mean(), theirs.mean(), rtol=1e-3)
    inexact = {entry.effect for entry in coverage if entry.state != EXACT}
    assert inexact <= {MORE_LIGHT_IN_CYCLES}  # of lamps, of which there are none here


def test_emission_is_dimmed_as_in_cycles(tmp_path):
    """Under alpha and a tinted coat; all else black, so that the pixel is what is emitted and what the coat
    and the transparency let come, the latter two known from above."""
    corners = {k: CORNERS[k] for k in ("Alpha", "Coat Weight", "Coat Roughness", "Coat IOR")}
    shape, links = drawn(1, corners)
    links["Emission Color"] = links["Base Color"]
    dark = {"Base Color": (0.0, 0.0, 0.0, 1.0), "Specular IOR Level": 0.0}
    pictures = [
        by_cycles_and_us(
            shape,
            lambda s=s: material("BsdfPrincipled", links | dark | {"Emission Strength": s}),
            256,
            tmp_path,
            points=256,
            emission=True,
        )
        for s in (0.0, 2.0)
    ]
    theirs, ours = (pictures[1][k] - pictures[0][k] for k in (0, 1))
    assert theirs.max() > 1.5
    np.testing.assert_allclose(ours, theirs, rtol=2e-3, atol=1e-3)
