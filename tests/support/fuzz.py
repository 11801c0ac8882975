"""Damaged snapshots: each is loaded, prepared and rendered, and must end with a picture or a clear error.

`python -m support.fuzz COUNT SEED` does so COUNT times and prints a JSON object of what came out.
"""

from __future__ import annotations

import collections
import dataclasses
import io
import json
import signal
import sys
import traceback
import warnings
import zipfile

import numpy as np
from support import rooms
from support import scenes as make
from support.motion import moving
from support.strands import among, cloud, strand, tuft

from pt_engine.render import integrators  # noqa: F401
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import (
    Graph,
    ImageData,
    LightData,
    Link,
    Linking,
    Node,
    Snapshot,
    Stereo,
    Visibility,
)
from pt_engine.scene.snapshot_io import SnapshotError, load_snapshot, save_snapshot

NUMPYS = ("operands", "cannot reshape", "setting an array", "could not convert")
CLEAR = (SnapshotError, ValueError, MemoryError)
HARD = [0.0, -0.0, -1.0, 1e-30, 1e30, 3e38, float("nan"), float("inf"), -float("inf"), 5.0, 2.0**31, 1e-7]
STRANGE = ["", "x", "GGX", "SUN", "PANO", "\0", "é" * 40, "-1"]
SECONDS = 20
IMAGE = {"image": 0, "extension": "REPEAT", "interpolation": "Linear", "projection": "FLAT"}


def whole() -> bytes:
    """A sound snapshot: a room with a ball of many nodes, and lamps."""
    return packed(still())


def packed(snapshot: Snapshot) -> bytes:
    """A snapshot's file."""
    stream = io.BytesIO()
    save_snapshot(snapshot, stream)
    return stream.getvalue()


def still() -> Snapshot:
    """The room."""
    lamps = [rooms.SOFT_LAMP, make_lamp("POINT", radius=0.1), make_lamp("SPOT"), make_lamp("SUN", angle=0.1)]
    image = ImageData("dots", pixels=np.random.default_rng(0).random((4, 8, 4), np.float32))
    snapshot = rooms.room(plastic(), sky=make.world(0.3))
    return dataclasses.replace(snapshot, lights=tuple(lamps), images=(image,))


def eventful() -> bytes:
    """The room with all that moves, bends, hides or is seen twice: more fields of the format."""
    base = still()
    hair = tuft(3, 4, 0.05, "RIBBON"), strand([(0, 0, 1), (1, 0, 1), (1, 1, 2)], shape="LINEAR")
    snapshot = among(base, hair, [cloud([(0, 0, 2), (0.5, 0, 2)], 0.1)])
    count = len(snapshot.instances.mesh)
    visibility = snapshot.instances.visibility.copy()
    visibility[-4:-1] = 63 | Visibility.CATCHER, 63 & ~Visibility.SHADOW, 63 | Visibility.HOLDOUT
    terminator = np.full(count, 0.1, np.float32)
    instances = dataclasses.replace(snapshot.instances, visibility=visibility, terminator=terminator)
    sets = np.arange(count, dtype=np.int32) % 2
    links = Linking(np.eye(2, dtype=np.uint8), np.ones((2, 2), np.uint8), sets, sets, sets)
    polynomial = (0.0, 0.8, 0.01, 0.0, 0.0)
    eye = dataclasses.replace(
        base.camera,
        kind="PANO",
        panorama="FISHEYE_LENS_POLYNOMIAL",
        frame=(-1.0, 1.0, -1.0, 1.0),
        fisheye_polynomial=polynomial,
        stereo=Stereo(0.03, 2.0, 1.0, 1.5),
    )
    later = dataclasses.replace(eye, matrix=make.translation(0.1, 0, 0) @ eye.matrix)
    path = np.stack([make.translation(0, 0, z) @ instances.matrix[2] for z in (0.0, 0.3, 0.4)])
    ball = base.meshes[2]
    shapes = ball.vertices, ball.vertices * np.float32(1.2)
    return packed(
        moving(
            dataclasses.replace(
                snapshot, instances=instances, linking=links, camera=eye, clear_glass=0.1, world_visibility=47
            ),
            instances={2: path},
            meshes={2: (np.stack(shapes), np.stack([ball.normals] * 2))},
            cameras=(eye, later),
            shutter=(0.0, 1.0, 1.0, 0.5),
        )
    )


def plastic() -> Graph:
    """Principled with a texture, a bump, noise in its roughness, and a coat."""
    nodes = (
        Node("TexImage", "image", {"Vector": None}, IMAGE),
        Node("TexNoise", "noise", {"Vector": None, "Scale": 3.0, "Detail": 2.0, "Roughness": 0.5}),
        Node("Bump", "bump", {"Height": Link(1, "Fac"), "Strength": 0.5, "Distance": 0.1, "Normal": None}),
        Node(
            "BsdfPrincipled",
            "shader",
            {
                "Base Color": Link(0, "Color"),
                "Roughness": Link(1, "Fac"),
                "Metallic": 0.2,
                "IOR": 1.5,
                "Transmission Weight": 0.3,
                "Coat Weight": 0.5,
                "Emission Color": make.WHITE,
                "Emission Strength": 0.0,
                "Normal": Link(2, "Normal"),
            },
        ),
    )
    return Graph("plastic", nodes, {"Surface": Link(3, "BSDF")})


def make_lamp(kind: str, **more: object):
    """A lamp over the room."""
    return LightData(kind, kind, make.looking((0.5, -0.5, 3.0), (0, 0, 0)), 20.0, **more)


class Mutator:
    """Damages a file: cuts it, flips its bytes, or changes its numbers and words and packs it again."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            self.members = {name: archive.read(name) for name in archive.namelist()}

    def __call__(self, rng: np.random.Generator) -> bytes:
        kind = rng.integers(10)
        if kind == 0:
            return self.content[: rng.integers(len(self.content))]
        if kind == 1:
            return flipped(self.content, rng)
        if kind < 6:
            return self.packed("snapshot.json", self.header(rng))
        name = str(rng.choice([name for name in self.members if name.endswith(".npy")]))
        return self.packed(name, self.array(self.members[name], rng))

    def packed(self, name: str, content: bytes) -> bytes:
        """The archive with one member replaced, its checksums right."""
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            for each, old in self.members.items():
                archive.writestr(each, content if each == name else old)
        return stream.getvalue()

    def header(self, rng: np.random.Generator) -> bytes:
        """The JSON with one to three of its leaves changed."""
        tree = json.loads(self.members["snapshot.json"])
        for _ in range(rng.integers(1, 4)):
            places = list(leaves(tree["snapshot"]))
            holder, key = places[rng.integers(len(places))]
            holder[key] = changed(holder[key], rng)
        return json.dumps(tree).encode()

    def array(self, content: bytes, rng: np.random.Generator) -> bytes:
        """An array with a few of its numbers changed, or its bytes flipped."""
        if rng.integers(3) == 0:
            return flipped(content, rng)
        array = np.load(io.BytesIO(content))
        if array.size:
            for _ in range(rng.integers(1, 4)):
                with np.errstate(all="ignore"), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    number = np.array(rng.choice(HARD)).astype(array.dtype)
                array.reshape(-1)[rng.integers(array.size)] = number
        stream = io.BytesIO()
        np.lib.format.write_array(stream, array, version=(1, 0))
        return stream.getvalue()


def flipped(content: bytes, rng: np.random.Generator) -> bytes:
    """Up to four bytes changed."""
    damaged = bytearray(content)
    for position in rng.integers(0, len(content), rng.integers(1, 5)):
        damaged[position] = rng.integers(256)
    return bytes(damaged)


def leaves(tree):
    """(holder, key) of every number, string, boolean or null of a JSON tree."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        if isinstance(value, (dict, list)):
            yield from leaves(value)
        else:
            yield tree, key


def changed(value, rng: np.random.Generator):
    """Another value, mostly of the same type."""
    if rng.integers(8) == 0:
        return [None, True, 7, "word", 1.5, []][rng.integers(6)]
    if isinstance(value, str):
        return STRANGE[rng.integers(len(STRANGE))]
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return int(rng.choice([-1, 0, 1, 2, 3, 9, 1000, 2**31, 2**63]))
    number = HARD[rng.integers(len(HARD))]
    return number if np.isfinite(number) else {"float": repr(number)}


def outcome(content: bytes) -> str:
    """What becomes of a file: "rendered", "refused", or the place where it went wrong."""
    try:
        snapshot = load_snapshot(io.BytesIO(content))
    except SnapshotError:
        return "refused"
    except Exception as error:
        return where(error)
    try:
        signal.alarm(SECONDS)
        result = render(prepare(snapshot), RenderSettings(4, 4, samples=1, threads=1, max_depth=3))
        return "rendered" if np.isfinite(result.image()).all() else "a picture that is not finite"
    except CLEAR as error:
        clear = str(error) and not str(error).startswith(NUMPYS)
        return f"told: {type(error).__name__}: {str(error)[:60]}" if clear else where(error)
    except Exception as error:
        return where(error)
    finally:
        signal.alarm(0)


def where(error: BaseException) -> str:
    """`TypeError at nodes/inputs.py:12: …`."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    file = "/".join(place.filename.split("/")[-2:])
    return f"{type(error).__name__} at {file}:{place.lineno}: {str(error)[:100]}"


def timed_out(number: int, frame: object) -> None:
    """A file that keeps the engine busy for ever."""
    raise TimeoutError(f"not done after {SECONDS} s")


def main() -> None:
    """See the module."""
    count, seed = int(sys.argv[1]), int(sys.argv[2])
    warnings.simplefilter("ignore")  # overflow is what is asked for
    signal.signal(signal.SIGALRM, timed_out)
    mutators, rng = [Mutator(whole()), Mutator(eventful())], np.random.default_rng(seed)
    found = collections.Counter(outcome(mutators[k % 2](rng)) for k in range(count))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
