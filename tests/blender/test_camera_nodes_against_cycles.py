"""Nodes that know the camera: its space and its image, through every kind of camera; objects and the sky."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import export  # noqa: E402
from support.seen_nodes import SIZE, build, case, compare, cycles  # noqa: E402

from pt_engine.cameras import make_camera  # noqa: E402
from pt_engine.core.raykind import RayKind  # noqa: E402
from pt_engine.nodes.world import compile_world  # noqa: E402
from pt_engine.scene.arrivals import Arrivals  # noqa: E402
from pt_engine.scene.prepare import view_of  # noqa: E402
from pt_engine.scene.sky_lanes import SkyLanes  # noqa: E402

SPACES = ("WORLD", "OBJECT", "CAMERA")
PANORAMAS = [
    "EQUIRECTANGULAR",
    "EQUIANGULAR_CUBEMAP_FACE",
    "MIRRORBALL",
    "FISHEYE_EQUIDISTANT",
    "FISHEYE_EQUISOLID",
    "FISHEYE_LENS_POLYNOMIAL",
    "CENTRAL_CYLINDRICAL",
]
NODES = [
    *(case("TexCoord", o) for o in ("Camera", "Window")),
    *(case("CameraData", o) for o in ("View Vector", "View Z Depth", "View Distance")),
    *(
        case(
            "VectorTransform",
            "Vector",
            links={"Vector": source},
            vector_type=kind,
            convert_from=here,
            convert_to=there,
        )
        for kind, source in (
            ("POINT", ("NewGeometry", "Position")),
            ("VECTOR", ("NewGeometry", "Incoming")),
            ("NORMAL", ("NewGeometry", "Normal")),
        )
        for here in SPACES
        for there in SPACES
        if "CAMERA" in (here, there) and here != there
    ),
]


@pytest.fixture(scope="module")
def stage():
    return build()


@pytest.fixture(name="through")
def _through(stage):
    """Sets the camera's kind; afterwards it is a perspective one again."""
    camera = stage[0].camera.data

    def change(kind, panorama=None):
        camera.type, camera.ortho_scale = kind, 6.0
        camera.shift_x, camera.shift_y = (0.0, 0.0) if kind == "PANO" else (0.05, -0.1)
        if panorama:
            camera.panorama_type = panorama

    yield change
    change("PERSP")


@pytest.mark.parametrize("c", NODES)
def test_camera_space_on_objects(c, stage, through):
    through("PERSP")
    compare(*stage, c)


@pytest.mark.parametrize("c", NODES[:5])
def test_orthographic_camera(c, stage, through):
    through("ORTHO")
    compare(*stage, c)


@pytest.mark.parametrize("c", NODES[:2])
@pytest.mark.parametrize("panorama", PANORAMAS)
def test_panoramas(panorama, c, stage, through):
    through("PANO", panorama)
    compare(*stage, c)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO", "EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT"])
@pytest.mark.parametrize(
    ("node", "output"),
    [
        ("TexCoord", "Window"),
        ("TexCoord", "Camera"),
        ("TexCoord", "Generated"),
        ("TexCoord", "Reflection"),
        ("CameraData", "View Vector"),
    ],
)
def test_the_sky(node, output, kind, stage, through):
    """A world that shines with a node's output, where no object is."""
    scene, _ = stage
    through(*((kind,) if kind in ("PERSP", "ORTHO") else ("PANO", kind)))
    scene.world = scene.world or bpy.data.worlds.new("World")
    tree = with_nodes(scene.world)
    scene.world.cycles.sampling_method = "NONE"  # its importance map takes Cycles two seconds
    source, shine = tree.nodes.new("ShaderNode" + node), tree.nodes.new("ShaderNodeBackground")
    end = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(source.outputs[output], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    hidden = [o for o in bpy.data.objects if o.type == "MESH"]
    for owner in hidden:
        owner.hide_render = True
    try:
        theirs, mine = cycles(scene), our_sky()
    finally:
        for owner in hidden:
            owner.hide_render = False
        scene.world = None
    error = np.abs(mine - theirs).max(axis=0) / (np.abs(theirs).max(axis=0) + 0.1)
    assert np.ptp(theirs) > 0
    assert (error > 2e-3).mean() < 0.01, (mine[:, error.argmax()], theirs[:, error.argmax()])


def our_sky():
    """(3, n) our sky at the pixels' centres; black where a panorama sees nothing."""
    snapshot = export()
    camera = make_camera(snapshot.camera, np.zeros(3), (SIZE, SIZE))
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    rays = camera.rays((np.stack([x.ravel(), y.ravel()]) + 0.5).astype(np.float32))
    origin = np.broadcast_to(rays.o, rays.d.shape)
    lanes = SkyLanes(rays.d, Arrivals.by(RayKind.CAMERA, SIZE * SIZE), view_of(snapshot.camera), origin)
    return compile_world(snapshot.world).emission(lanes) * (rays.tfar > 0)
