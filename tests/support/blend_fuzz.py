"""Damaged .blend files: each is opened by Blender, then exported, prepared and rendered.

    python -m support.blend_fuzz COUNT [SEED]     prints how many ended in which way

Files are tried one after another in a process, which is started anew when it dies. Blender itself may die
of such a file, as it opens or evaluates it or is asked for what it has read (numpy does not): that is
counted, and not ours. While a scene is prepared and rendered only our own libraries are at work, and
whatever was read, the end has to be a picture or a clear error.
"""

from __future__ import annotations

import collections
import contextlib
import faulthandler
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
SECONDS = 60  # for one file
WANTED = {b"SC", b"OB", b"ME", b"MA", b"CA", b"LA", b"WO", b"NT", b"DATA", b"GR", b"IM", b"AC", b"CV"}
HARD = [0, 1, -1, 2**31 - 1, -(2**31), 65535, 0x7F800000, 0x7FC00000, 0x3F800000, 0x00000001, 0x60AD78EC]
STAGES = {
    "open": "Blender",
    "evaluate": "Blender",
    "export": "Blender",
    "prepare": "engine",
    "render": "engine",
}


def sound(path: Path) -> None:
    """Write a small file with textures, modifiers, instances, lamps, strands, links, and things that move."""
    import bpy
    from support.bpy_motion import animate
    from support.engine_scene import engine_scene

    scene = engine_scene(samples=1)
    scene.render.resolution_x = scene.render.resolution_y = 4
    cube = scene.objects["Cube"]
    cube.modifiers.new("Subdivision", "SUBSURF")
    material = bpy.data.materials.new("Material")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    noise, bump = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump")
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    tree.links.new(noise.outputs[1], shader.inputs["Base Color"])
    cube.data.materials.append(material)
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects.new("Ball", cube.data))
    for k in range(3):
        placed = bpy.data.objects.new(f"Placed {k}", None)
        placed.instance_type, placed.instance_collection = "COLLECTION", group
        placed.location = k, 1, 0
        scene.collection.objects.link(placed)
    lamp = bpy.data.lights.new("Area", "AREA")
    scene.collection.objects.link(bpy.data.objects.new("Area", lamp))
    strands = bpy.data.hair_curves.new("Tuft")
    strands.add_curves([3, 4])
    strands.attributes["position"].data.foreach_set("vector", np.linspace(0, 1, 21, dtype=np.float32))
    scene.collection.objects.link(bpy.data.objects.new("Tuft", strands))
    scene.objects["Lamp"].light_linking.receiver_collection = group
    cube.is_shadow_catcher = True
    scene.render.use_motion_blur = True
    animate(scene.objects["Tuft"], "location", [(0, 0, 1), (1, 0, 1), (1, 1, 1)])
    animate(cube, "rotation_euler", [(0, 0, 0), (0, 0, 1), (0, 1, 1)])
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)


def blocks(content: bytes) -> list[tuple[int, int]]:
    """(start, length) of data blocks that a render may depend on; all of the file where it is unreadable."""
    large = content[:7] == b"BLENDER" and content[7:9].isdigit()  # from Blender 5 on
    place, head = (int(content[7:9]), "<4s i Q q q") if large else (12, "<4s i Q i i")
    found = []
    while place + struct.calcsize(head) <= len(content):
        code, a, _, b, _ = struct.unpack_from(head, content, place)
        size = b if large else a
        place += struct.calcsize(head)
        if size < 0 or place + size > len(content):
            break
        if code.strip(b"\0") in WANTED and size >= 4:
            found.append((place, size))
        place += size
    return found or [(0, len(content))]


def damaged(content: bytes, number: int, seed: int) -> bytes:
    """One in six cut off; of the rest, up to eight words or bytes of data blocks changed."""
    rng = np.random.default_rng([seed, number])
    if rng.integers(6) == 0:
        return content[: rng.integers(len(content))]
    out, places = bytearray(content), blocks(content)
    for _ in range(rng.integers(1, 9)):
        start, size = places[rng.integers(len(places))]
        word = start + 4 * int(rng.integers(size // 4))
        if rng.integers(2):
            out[word : word + 4] = struct.pack("<I", HARD[rng.integers(len(HARD))] & 0xFFFFFFFF)
        else:
            out[word + rng.integers(4)] = rng.integers(256)
    return bytes(out)


def child(file: str, seed: int, first: int, end: int) -> None:
    """Try the files `first` … `end` − 1; tell each stage as it begins, and how each file ended."""
    from pt_engine.blender import registration

    registration.register()
    content = Path(file).read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.blend"
        for number in range(first, end):
            path.write_bytes(damaged(content, number, seed))
            faulthandler.dump_traceback_later(SECONDS, exit=True)
            say("end", number, outcome(path, number))
            faulthandler.cancel_dump_traceback_later()


def say(*words: object) -> None:
    """One line of JSON in the diary, at once."""
    with open(os.environ["DIARY"], "a", encoding="utf-8") as diary:
        diary.write(json.dumps(words) + "\n")


def outcome(path: Path, number: int) -> str:
    """What became of a file."""
    import bpy

    from pt_engine.blender.export import export_scene
    from pt_engine.blender.refusal import EXPECTED
    from pt_engine.blender.settings import settings_of
    from pt_engine.render.progressive import render
    from pt_engine.scene.prepare import prepare

    say("open", number)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path))
    except RuntimeError:
        return "refused by Blender"
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = 100
    say("evaluate", number)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    try:
        say("export", number)
        snapshot = export_scene(
            depsgraph, frame_set=lambda frame, part: scene.frame_set(frame, subframe=part)
        )
        settings = settings_of(scene, 4, 4)
        say("prepare", number)
        prepared = prepare(snapshot, memory=1 << 30)
        say("render", number)
        image = render(prepared, settings).image()
    except EXPECTED:
        return "refused"
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__} at {'/'.join(Path(last.filename).parts[-2:])}:{last.lineno}: {error}"
    return "rendered" if np.isfinite(image).all() else "a picture that is not finite"


def crash(stage: str, errors: str) -> str:
    """In whose hands the process died, by the stage and the innermost frame of the stack."""
    frame = re.search(r'File "(.*?)", line (\d+)', errors)
    place = f"{'/'.join(Path(frame[1]).parts[-2:])}:{frame[2]}" if frame else "nowhere"
    return f"{STAGES.get(stage, 'start')} died in {stage}: {place}"


def tried(count: int, seed: int) -> collections.Counter[str]:
    """How `count` damaged files ended."""
    found: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "sound.blend")
        run("sound", file)
        first = 0
        while first < count:
            lines, errors = run("child", file, str(seed), str(first), str(count))
            stage, number = "start", first
            for what, at, *how in lines:
                stage, number = what, at
                found.update(how)
            first = number + 1
            if stage != "end":
                found[crash(stage, errors)] += 1
    return found


def run(*words: str) -> tuple[list[list], str]:
    """What a new process says in its diary, and its standard error."""
    code = "import sys; from support.blend_fuzz import main; main(sys.argv[1:])"
    path = os.pathsep.join(str(ROOT / part) for part in (".", "tests"))
    with tempfile.NamedTemporaryFile("r", encoding="utf-8") as diary:
        done = subprocess.run(
            [sys.executable, "-X", "faulthandler", "-c", code, *words],
            env={**os.environ, "PYTHONPATH": path, "DIARY": diary.name},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            check=False,
        )
        return [json.loads(line) for line in diary], done.stderr


def main(words: list[str]) -> None:
    """See the module; "sound" and "child" are what it starts itself."""
    if words[0] == "sound":
        sound(Path(words[1]))
    elif words[0] == "child":
        with contextlib.suppress(KeyboardInterrupt):
            child(words[1], *(int(word) for word in words[2:]))
    else:
        print(
            json.dumps(
                dict(tried(*(int(word) for word in words), *([7] if len(words) == 1 else []))), indent=1
            )
        )


if __name__ == "__main__":
    main(sys.argv[1:])
