"""A snapshot's file gives back the very bits, and a bad file gives a clear error."""

import dataclasses
import io
import json
import pickle
import zipfile

import numpy as np
import pytest

from pt_engine.scene import snapshot as data
from pt_engine.scene.snapshot_io import SnapshotError, load_snapshot, save_snapshot


def graph(name="Material"):
    nodes = (
        data.Node("TexImage", "Group/Image", {"Vector": None}, {"image": 0, "extension": "REPEAT"}),
        data.Node(
            "BsdfPrincipled",
            "BSDF",
            {"Base Color": data.Link(0, "Color"), "Roughness": 0.1 + 0.2, "IOR": float("inf")},
            {"flag": True, "ramp": ("RGB", "EASE", ((0.0, 1.0, 0.0, 0.0, 1.0),)), "none": None, "count": 3},
        ),
    )
    return data.Graph(name, nodes, {"Surface": data.Link(1, "BSDF")}, (("BSDF", "a note"),))


def small_snapshot():
    rng = np.random.default_rng(0)
    triangles = rng.integers(0, 8, (12, 3)).astype(np.int32)
    mesh = data.MeshData(
        name="Würfel",
        vertices=rng.random((8, 3), np.float32),
        triangles=triangles,
        material_slot=np.zeros(12, np.int32),
        normals=rng.random((8, 3), np.float32),
        normal_index=triangles,
        corner_index=np.arange(36, dtype=np.int32).reshape(12, 3),
        uvs={"UVMap": np.array([[np.nan, -0.0]] * 36, np.float32)},
        colors={"Paint": rng.random((36, 4), np.float32)},
        orco=rng.random((8, 3), np.float32),
    )
    instances = data.Instances(
        mesh=np.zeros(2, np.int32),
        matrix=rng.random((2, 4, 4)),
        materials=np.array([[0, 1]] * 2, np.int32),
        random=rng.random(2, np.float32),
        color=rng.random((2, 4), np.float32),
        pass_index=np.zeros(2, np.int32),
        visibility=np.full(2, 63, np.uint8),
        names=("a", "b"),
        attributes={"object:prop": rng.random((2, 4), np.float32)},
        terminator=np.array([0.1, 0.0], np.float32),
    )
    images = (
        data.ImageData("file", encoded=np.frombuffer(b"\x89PNG", np.uint8), suffix=".png"),
        data.ImageData("pixels", pixels=rng.random((2, 3, 4), np.float32)),
        data.ImageData("gone", problem="no such file"),
        data.ImageData("bytes", pixels=rng.integers(0, 256, (2, 3, 4), np.uint8)),
        data.ImageData("udim", tiles=((1001, 0), (1012, 2)), as_rgba=True),
    )
    lights = (data.LightData("POINT", "Lamp", np.eye(4), 10.0, graph=graph("Lamp")),)
    curves = data.CurvesData(
        name="hair",
        points=rng.random((5, 3), np.float32),
        radius=rng.random(5, np.float32),
        first=np.array([0, 2, 5], np.int32),
        material_slot=np.zeros(2, np.int32),
        uvs={"UVMap": rng.random((2, 2), np.float32)},
        colors={"by point": rng.random((5, 4), np.float32), "by curve": rng.random((2, 4), np.float32)},
        generated=rng.random((2, 3), np.float32),
    )
    points = data.PointsData("cloud", rng.random((3, 3), np.float32), rng.random(3, np.float32))
    camera = data.CameraData("PANO", np.eye(4), (-1.0, 1.0, -0.5, 0.5), panorama="MIRRORBALL")
    return data.Snapshot(
        (mesh,), instances, (graph("none"), graph()), images, lights, graph("World"), camera,
        unsupported=(("where", "what", "effect"),), curves=(curves,), points=(points,),
    )  # fmt: skip


def saved(snapshot):
    stream = io.BytesIO()
    save_snapshot(snapshot, stream)
    return stream.getvalue()


def loaded(content):
    return load_snapshot(io.BytesIO(content))


def assert_same(a, b, where="snapshot"):
    assert type(a) is type(b), where
    if isinstance(a, np.ndarray):
        assert (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes()), where
    elif dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            assert_same(getattr(a, field.name), getattr(b, field.name), f"{where}.{field.name}")
    elif isinstance(a, tuple):
        assert len(a) == len(b), where
        for number, pair in enumerate(zip(a, b, strict=True)):
            assert_same(*pair, f"{where}[{number}]")
    elif isinstance(a, dict):
        assert list(a) == list(b), where
        for key in a:
            assert_same(a[key], b[key], f"{where}[{key}]")
    else:
        assert a == b, where


def test_round_trip_is_exact():
    snapshot = small_snapshot()
    assert_same(loaded(saved(snapshot)), snapshot)


def test_a_shared_array_is_stored_once_and_shared_again():
    mesh = loaded(saved(small_snapshot())).meshes[0]
    assert mesh.normal_index is mesh.triangles


def test_equal_snapshots_make_equal_files():
    assert saved(small_snapshot()) == saved(small_snapshot())


def test_file_on_disk(tmp_path):
    save_snapshot(small_snapshot(), tmp_path / "a.ptsnap")
    assert_same(load_snapshot(tmp_path / "a.ptsnap"), small_snapshot())
    with pytest.raises(SnapshotError, match="No such file"):
        load_snapshot(tmp_path / "b.ptsnap")


def test_truncated_files_are_refused():
    content = saved(small_snapshot())
    for size in np.linspace(0, len(content) - 1, 60).astype(int):
        with pytest.raises(SnapshotError):
            loaded(content[:size])


def test_mutated_files_are_refused_or_well_formed():
    content = saved(small_snapshot())
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(400):
        mutated = bytearray(content)
        for position in rng.integers(0, len(content), 4):
            mutated[position] = rng.integers(0, 256)
        try:
            loaded(bytes(mutated))
        except SnapshotError:
            refused += 1
    assert refused > 350  # the rest hit bytes that zip doesn't read


def repacked(change, arrays=None):
    """The small snapshot's file with its JSON tree changed and members replaced."""
    with zipfile.ZipFile(io.BytesIO(saved(small_snapshot()))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    header = json.loads(members["snapshot.json"])
    change(header)
    members["snapshot.json"] = json.dumps(header).encode()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in (members | (arrays or {})).items():
            archive.writestr(name, content)
    return stream.getvalue()


def npy(array, **options):
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def mesh_fields(header):
    return header["snapshot"]["Snapshot"]["meshes"]["tuple"][0]["MeshData"]


def set_in(*path):
    """A change of the header: everything up to the last item is the way, the last the new value."""

    def change(header):
        target = header["snapshot"]["Snapshot"]
        for key in path[:-2]:
            target = target[key]
        target[path[-2]] = path[-1]

    return change


def test_unchanged_repacking_loads():
    assert_same(loaded(repacked(lambda header: None)), small_snapshot())


@pytest.mark.parametrize(
    "change",
    [
        lambda header: header.update(version=2),
        lambda header: header.update(format="another"),
        lambda header: header.update(snapshot=[1, 2]),
        lambda header: header.update(snapshot={"Popen": {"args": "ls"}}),
        lambda header: header.update(snapshot={"array": 0}),
        lambda header: mesh_fields(header).update(vertices=None),
        lambda header: mesh_fields(header).update(vertices=mesh_fields(header)["triangles"]),
        lambda header: mesh_fields(header).update(vertices={"array": 99}),
        lambda header: mesh_fields(header).update(vertices={"array": "../0"}),
        lambda header: mesh_fields(header).update(unknown=1),
        lambda header: mesh_fields(header).update(normal_index=None),
        lambda header: mesh_fields(header).pop("triangles"),
        lambda header: mesh_fields(header).update(uvs={"dict": [["a", mesh_fields(header)["normals"]]]}),
        set_in("frame", "one"),
        set_in("exposure", True),
        set_in("camera", None),
        set_in("camera", "CameraData", "clip", {"tuple": [1.0]}),
        set_in("camera", "CameraData", "fisheye_polynomial", {"tuple": [1.0, 2.0]}),
        set_in("instances", "Instances", "names", {"tuple": ["a"]}),
        set_in("materials", {"tuple": []}),
        set_in("images", {"tuple": []}),
        set_in("world", "Graph", "outputs", {"dict": [["Surface", {"link": [7, "BSDF"]}]]}),
        set_in("world", "Graph", "outputs", {"dict": [["Surface", {"link": [-1, "BSDF"]}]]}),
        set_in("world", "Graph", "name", {"dict": []}),
        set_in("images", "tuple", 4, "ImageData", "tiles", {"tuple": [{"tuple": [1001, 4]}]}),  # itself
        set_in("images", "tuple", 4, "ImageData", "tiles", {"tuple": [{"tuple": [1001, 5]}]}),
        set_in("images", "tuple", 4, "ImageData", "tiles", {"tuple": [{"tuple": [7, 0]}]}),
        set_in("images", "tuple", 1, "ImageData", "tiles", {"tuple": [{"tuple": [1001, 0]}]}),  # with pixels
    ],
)
def test_tampered_headers_are_refused(change):
    with pytest.raises(SnapshotError):
        loaded(repacked(change))


def triangle_member():
    with zipfile.ZipFile(io.BytesIO(saved(small_snapshot()))) as archive:
        header = json.loads(archive.read("snapshot.json"))
    return f"{mesh_fields(header)['triangles']['array']}.npy"


@pytest.mark.parametrize(
    "content",
    [
        npy(np.full((12, 3), 8, np.int32)),  # past the last vertex
        npy(np.full((12, 3), -1, np.int32)),
        npy(np.zeros((12, 3), np.int64)),
        npy(np.asfortranarray(np.zeros((12, 3), np.int32))),
        npy(np.zeros((12, 4), np.int32)),
        npy(np.zeros((12, 3), np.int32))[:-4],
        npy(np.zeros((12, 3), np.int32)).replace(b"(12, 3)", b"(2**9,)"),
        npy(np.zeros((12, 3), np.int32)).replace(b"(12, 3), }      ", b"(1200000000, 3)}"),
        npy(np.array([[print]], object), allow_pickle=True),
        pickle.dumps(np.zeros((12, 3), np.int32)),
        b"",
    ],
)
def test_tampered_arrays_are_refused(content):
    with pytest.raises(SnapshotError):
        loaded(repacked(lambda header: None, {triangle_member(): content}))


def test_compressed_members_are_refused():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("snapshot.json", "{}" + " " * 1_000_000)
    with pytest.raises(SnapshotError, match="compressed"):
        loaded(stream.getvalue())


def test_endless_nesting_is_refused():
    nested = '{"tuple": [' * 100_000 + "]}" * 100_000
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(
            "snapshot.json", '{"format": "pt_engine snapshot", "version": 1, "snapshot": ' + nested + "}"
        )
    with pytest.raises(SnapshotError):
        loaded(stream.getvalue())


def moving_snapshot():
    """The small one with an instance, its mesh and the camera in motion."""
    still = small_snapshot()
    mesh = still.meshes[0]
    motion = data.Motion(
        np.array([0, 1, 0.5], np.float32),
        (data.InstanceMotion(np.array([1], np.int32), np.stack([still.instances.matrix] * 3)[None, :, 1]),),
        (data.MeshMotion(0, np.stack([mesh.vertices] * 2), np.stack([mesh.normals] * 2)),),
        (still.camera, still.camera),
    )
    return dataclasses.replace(still, motion=motion)


def test_a_motion_comes_back_as_it_was():
    assert_same(loaded(saved(moving_snapshot())), moving_snapshot())


@pytest.mark.parametrize(
    "change",
    [
        {"shutter": np.ones(1, np.float32)},
        {"instances": (data.InstanceMotion(np.array([7], np.int32), np.zeros((1, 3, 4, 4))),)},
        {"instances": (data.InstanceMotion(np.array([0], np.int32), np.zeros((1, 1, 4, 4))),)},
        {"instances": (data.InstanceMotion(np.array([0], np.int32), np.zeros((2, 3, 4, 4))),)},
        {"meshes": (data.MeshMotion(3, np.zeros((2, 8, 3), np.float32)),)},
        {"meshes": (data.MeshMotion(0, np.zeros((2, 8, 3), np.float32)),)},
        {"meshes": (data.MeshMotion(0, *[np.zeros((2, 7, 3), np.float32)] * 2),)},
        {"meshes": (data.MeshMotion(0, *[np.zeros((1, 8, 3), np.float32)] * 2),)},
        {"cameras": (small_snapshot().camera,)},
    ],
)
def test_motions_that_do_not_fit_are_refused(change):
    whole = moving_snapshot()
    wrong = dataclasses.replace(whole, motion=dataclasses.replace(whole.motion, **change))
    with pytest.raises(SnapshotError, match="malformed"):
        loaded(saved(wrong))


def test_what_a_snapshot_cannot_hold_is_refused_on_saving():
    snapshot = dataclasses.replace(small_snapshot(), unsupported=(object(),))
    with pytest.raises(SnapshotError, match="can't hold"):
        saved(snapshot)


@pytest.mark.parametrize(
    "broken",
    [
        {"first": np.array([0, 4, 3], np.int32)},
        {"first": np.array([0, 2, 6], np.int32)},
        {"radius": np.zeros(4, np.float32)},
        {"shape": "ROUND"},
        {"subdivisions": 1000},
        {"uvs": {"a": np.zeros((3, 2), np.float32)}},
        {"colors": {"a": np.zeros((3, 4), np.float32)}},
        {"material_slot": np.array([0, -1], np.int32)},
    ],
)
def test_curves_that_point_past_their_arrays_are_refused(broken):
    snapshot = small_snapshot()
    curves = dataclasses.replace(snapshot.curves[0], **broken)
    with pytest.raises(SnapshotError):
        loaded(saved(dataclasses.replace(snapshot, curves=(curves,))))


def instance_fields(header):
    return header["snapshot"]["Snapshot"]["instances"]["Instances"]


def test_a_file_from_before_a_field_has_its_default():
    assert (
        loaded(repacked(lambda header: instance_fields(header).pop("terminator"))).instances.terminator
        is None
    )


def test_terminators_of_another_number_are_refused():
    other = repacked(
        lambda header: instance_fields(header).update(terminator=instance_fields(header)["color"])
    )
    with pytest.raises(SnapshotError, match=r"instances\.terminator"):
        loaded(other)
