"""Scale and place: the same picture however large, small or far away a scene is; no leaks and no acne."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..render.progressive import RenderResult
from ..scene.snapshot import LightData, Snapshot
from . import scenes as make
from .case import Group
from .rays import SHELLS, false_hits, leaks, naive_fixed, shot

SCALE = Group("Scale and place")
PLACE = (0.31, -0.52, 0.7)  # nothing is to lie in a coordinate plane by luck
SIZES = (1e-4, 1e-2, 1.0, 1e3, 1e6)
Float64 = NDArray[np.float64]


def still_life(size: float = 1.0, away: Float64 | None = None) -> Snapshot:
    """A ball on a floor under an area lamp, a bright square and a sky; `size` in metres, moved by `away`."""
    place = np.eye(4) if away is None else make.translation(*away)
    place = place @ np.diag([size, size, size, 1.0])
    lamp = place @ make.looking((0.5, -0.7, 2.0), (0, 0, 0))
    lamp[:3, :3] /= size
    area = LightData("AREA", "lamp", lamp, 60.0 * size**2, size=(size, size))
    glow = place @ make.translation(-1.5, 0.2, 1.2)
    objects = [
        (make.quad(6.0), place @ make.translation(0, 0, -0.5), make.diffuse(0.6, "floor")),
        (make.sphere(0.5, 24), place, make.shader("BsdfGlossy", "ball", Color=make.WHITE, Roughness=0.3)),
        (make.quad(0.8), glow, make.emission(2.0)),
    ]
    camera = make.perspective((0.1, -3.0, 1.5), (0, 0, 0), 0.4)
    matrix = place @ camera.matrix
    matrix[:3, :3] /= size
    camera = replace(camera, matrix=matrix, clip=(1e-4 * size, 1e6 * size))
    return make.scene(objects, camera, [area], make.world(0.1))


def picture(snapshot: Snapshot) -> Float64:
    """(16, 16, 3), the same random numbers each time."""
    return image(make.rendered(snapshot, 16, samples=16, max_depth=4))


def image(result: RenderResult) -> Float64:
    """Colours of a render."""
    return result.image()[..., :3].astype(np.float64)


def difference(a: Float64, b: Float64) -> float:
    """Mean absolute difference over the mean; NaN stays NaN."""
    return float(np.abs(a - b).mean() / np.abs(b).mean())


@SCALE.case(
    "scene scaled by 1e-4 … 1e6",
    "offsets, cut-offs and areas in metres fail at other sizes",
    "largest relative difference of pictures with equal random numbers",
    0.0,
    2e-3,
    "paths that graze an edge go the other way: one sample in a thousand at the most",
)
def scaled() -> float:
    reference = picture(still_life())
    return max(difference(picture(still_life(size)), reference) for size in SIZES)


@SCALE.case(
    "scene moved by 1e6 of its size",
    "float32 has a spacing of 0.06 at 1e6; the scene is recentred in float64 first",
    "relative difference from the picture at the origin",
    0.0,
    2e-3,
    "as above",
    naive=lambda: moved_in_float32(1e6),
)
def moved() -> float:
    reference = picture(still_life())
    return max(
        difference(picture(still_life(1.0, np.multiply(PLACE, k))), reference) for k in (1e2, 1e4, 1e6)
    )


def moved_in_float32(distance: float) -> float:
    """The same with the place written into the vertices, as an engine has it that keeps world space."""
    here, there = still_life(), still_life(1.0, np.multiply(PLACE, distance))
    meshes = tuple(
        replace(mesh, vertices=(mesh.vertices + matrix[:3, 3]).astype(np.float32))
        for mesh, matrix in zip(there.meshes, there.instances.matrix, strict=True)
    )
    matrix = there.instances.matrix.copy()
    matrix[:, :3, 3] = 0
    return difference(
        picture(replace(there, meshes=meshes, instances=replace(there.instances, matrix=matrix))),
        picture(here),
    )


@SCALE.case(
    "an object of 1e-3 beside one of 1e4",
    "one space holds both, with float32's spacing of 1e-3 at 1e4",
    "radiance of the small lamp, seen from 2e-3",
    1.0,
    0.0,
    "the small one stands at the centre, where the spacing is finest",
)
def small_beside_large() -> float:
    small = (make.quad(1e-3), np.eye(4), make.emission(1.0))
    ring = [(make.quad(1e4), make.translation(x, 0, -1), make.diffuse(0.5)) for x in (-1e4, 1e4)]
    camera = replace(make.orthographic((0, 0, 2e-3), (0, 0, 0), 1e-3), clip=(1e-6, 1e6))
    return float(image(make.rendered(make.scene([small, *ring], camera), 8, samples=4)).mean())


@SCALE.case(
    "near clip of 1e-6, far clip of infinity",
    "a near clip is added to the eye; a far clip is a length of rays",
    "radiance of a lamp 1e-3 before the camera",
    1.0,
    0.0,
    "nothing is to be estimated",
)
def clips() -> float:
    camera = replace(make.perspective((0, 0, 1e-3), (0, 0, 0)), clip=(1e-6, float("inf")))
    snapshot = make.scene([(make.quad(1.0), np.eye(4), make.emission(1.0))], camera)
    return float(image(make.rendered(snapshot, 8, samples=4)).mean())


@SCALE.case(
    "pixels of an image of 16,384²",
    "a place in the image is counted in float32, whose spacing there is a thousandth of a pixel",
    "largest distance of rays from where they should go, in pixels, at the corners, edges and middle",
    0.0,
    5e-3,
    "three roundings of 2⁻²⁴ of 16,384 pixels",
)
def huge_image() -> float:
    edge = 1 << 14
    corners = np.array([1, edge // 2, edge - 1])[:, None] + np.random.default_rng(0).random((1, 200)) - 0.5
    raster = np.stack([a.ravel() for a in np.meshgrid(corners.ravel(), corners.ravel())])
    camera = make_camera(make.perspective((0, 0, 0), (0, 1, 0)), np.zeros(3)).at_resolution(edge, edge)
    d = camera.rays(raster.astype(np.float32)).d.astype(np.float64)
    found = np.stack([d[0], d[2]]) / d[1]  # it looks along Y, and half its image is 0.5 wide at distance 1
    return float(np.abs((found + 0.5) * edge - raster).max())


@SCALE.case(
    "closed boxes hold rays",
    "a ray that starts on a wall must not slip through it or its edges",
    "escapes per million cosine-distributed rays in boxes from 1e-3 to 1e4",
    0.0,
    20.0,
    "Embree's own edge test rounds: up to 5 were seen",
    naive=lambda: leaks(naive_fixed(1e-2)),
)
def leaking() -> float:
    return leaks()


@SCALE.case(
    "no acne on balls, planes and slivers",
    "a ray that leaves a convex surface must not meet it again; offsets are the triangle's own error bound",
    "false hits per million rays, at sizes from 1e-3 to 1e4 and away from the origin",
    0.0,
    0.0,
    "a bound is a bound",
    naive=lambda: false_hits(naive_fixed(1e-6)),
)
def acne() -> float:
    return false_hits()


@SCALE.case(
    "false shadows of a moved scene",
    "an offset in proportion to the scene's size knows nothing of where the scene is",
    "false hits per million rays of a ball of 1e-2 at a distance of 100",
    0.0,
    0.0,
    "a bound is a bound",
    naive=lambda: shot(SHELLS["moved"], naive_fixed(1e-9)),
)
def moved_acne() -> float:
    return shot(SHELLS["moved"])
