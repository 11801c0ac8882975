"""Open a .blend and apply what the command line says in place of it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

from ...render.integrator import INTEGRATORS
from .. import plugins
from ..compatibility import ENGINE
from ..failure import Failure, UsageError
from ..settings import adapts, endless
from .chatter import unechoed

LEAST_PIXELS = 4  # along a side at 100 %
VALUES = (
    *("samples", "seconds", "target_error", "target_percentile", "min_samples"),
    *("seed", "max_depth", "integrator"),
)


def open_scene(arguments):
    """The file's active scene, ready to render."""
    scene = open_settings(arguments)
    if scene.camera is None:
        raise Failure(f"scene {scene.name!r} of {arguments.file} has no camera")
    return scene


def open_settings(arguments):
    """The file's active scene with the settings of the command line; its scripts are not run."""
    for path in arguments.plugins:
        try:
            plugins.load(path)
        except plugins.PluginError as error:
            raise Failure(str(error)) from error
    open_file(arguments.file)
    if not getattr(arguments, "quiet", False):
        warn_of_newer(arguments.file)
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    choose_frame(scene, arguments.frame)
    apply(scene, arguments)
    return scene


def open_file(path: Path) -> None:
    """Load a .blend, or say why not."""
    if not path.exists():
        raise Failure(f"no such file: {path}")
    if not path.is_file() or not os.access(path, os.R_OK):
        raise Failure(f"{path} is a directory or may not be read")
    try:
        with unechoed():
            bpy.ops.wm.open_mainfile(filepath=str(path.absolute()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1].removeprefix("Error: ")
        raise Failure(f"{path} can't be read as a .blend: {reason}") from error


def warn_of_newer(path: Path) -> None:
    """Blender opens files of its later versions and leaves out what it does not know."""
    theirs, ours = tuple(bpy.data.version[:2]), bpy.app.version[:2]
    if theirs > ours:
        print(
            f"pt_engine: {path} is of Blender {theirs[0]}.{theirs[1]}, newer than this one, "
            f"{ours[0]}.{ours[1]}: what that does not know is left out",
            file=sys.stderr,
        )


def choose_frame(scene, frame: int | None) -> None:
    """Go to a frame of the scene's range; without one the file's own frame stays."""
    if frame is None:
        frame = scene.frame_current
    elif not scene.frame_start <= frame <= scene.frame_end:
        first, last = scene.frame_start, scene.frame_end
        raise Failure(f"no frame {frame}: scene {scene.name!r} has the frames {first} to {last}")
    scene.frame_set(frame)


def choose_view_layer(scene, name: str | None) -> str:
    """The view layer to render: the named one, else the file's active one."""
    if name is None:
        active = bpy.context.view_layer.name
        return active if active in scene.view_layers else scene.view_layers[0].name
    if name not in scene.view_layers:
        raise Failure(f"no view layer {name!r}: there are {', '.join(scene.view_layers.keys())}")
    return name


def apply(scene, arguments) -> None:
    """Settings from the command line; --set comes last."""
    own, render = scene.pt_engine, scene.render
    render.use_compositing = render.use_sequencer = False
    own.stats_path = ""
    if arguments.size:
        choose_size(render, *arguments.size)
    if arguments.threads is not None:
        render.threads_mode = "FIXED" if arguments.threads else "AUTO"
        render.threads = arguments.threads or render.threads
    if arguments.target_error and arguments.samples is None:
        own.samples = 0  # the file's number is no limit to an error that is asked for by name
    for key in VALUES:
        if (value := getattr(arguments, key)) is not None:
            assign(own, key, str(value))
    for key in ("strict", "adaptive"):
        if getattr(arguments, key):
            setattr(own, key, True)
    if arguments.target_percentile is not None:
        own.target_of = "PIXELS"
    for key, text in arguments.assignments:
        assign(own, key, text)
    if endless(own):
        raise UsageError("neither samples, seconds nor error are limited: this render would never end")
    if arguments.target_percentile is not None and not own.target_error:
        raise UsageError("--target-percentile has no effect without --target-error")
    if arguments.adaptive and not adapts(own):
        raise UsageError(
            "--adaptive needs --samples or --target-error, which say how many a noisy pixel may get"
        )


def choose_size(render, width: int, height: int) -> None:
    """The image's size; Blender knows fewer than four pixels along a side only as a part of more."""
    part = 1 if min(width, height) >= LEAST_PIXELS else LEAST_PIXELS
    render.resolution_x, render.resolution_y = width * part, height * part
    render.resolution_percentage = 100 // part
    if (render.resolution_x, render.resolution_y) != (width * part, height * part):
        raise UsageError(f"no image is {width}x{height}: one of under {LEAST_PIXELS} pixels is not that long")


def assign(own, key: str, text: str) -> None:
    """Set a property of the engine from text; an unknown key or a value out of range is a usage error."""
    known = {p.identifier: p for p in own.bl_rna.properties if p.identifier not in ("rna_type", "name")}
    if key not in known:
        raise UsageError(f"the engine has no property {key!r}; it has {', '.join(sorted(known))}")
    try:
        setattr(own, key, value_of(known[key], text))
    except (ValueError, TypeError) as error:
        raise UsageError(f"{key}: {error}") from error


def value_of(prop, text: str):
    """Text as the value of a property, in its range."""
    if prop.type == "BOOLEAN":
        if text.lower() not in BOOLEANS:
            raise ValueError(f"{text!r} is not one of {', '.join(BOOLEANS)}")
        return BOOLEANS[text.lower()]
    if prop.type == "ENUM":
        names = INTEGRATORS if prop.identifier == "integrator" else prop.enum_items.keys()
        if text not in names:
            raise ValueError(f"{text!r} is not one of {', '.join(names)}")
        return text
    if prop.type not in ("INT", "FLOAT"):
        return text
    try:
        value = int(text) if prop.type == "INT" else float(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a{' whole' if prop.type == 'INT' else ''} number") from None
    if not prop.hard_min <= value <= prop.hard_max:
        raise ValueError(f"{text} is not between {prop.hard_min} and {prop.hard_max}")
    return value


BOOLEANS = {
    "true": True,
    "on": True,
    "yes": True,
    "1": True,
    "false": False,
    "off": False,
    "no": False,
    "0": False,
}
