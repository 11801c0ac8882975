"""Samples that had to be dropped, in words: where they came from, and the command that shows one again."""

from __future__ import annotations

import shlex

PATH_SETTINGS = (
    "rr_depth",
    "transparent_depth",
    "clamp_direct",
    "clamp_indirect",
    "sampler",
    "pixel_filter",
    "filter_width",
)


def add_commands(dropped, settings, file: str, frame: int, view_layer: str, view: str = "") -> None:
    """Give each dropped sample the command that replays it."""
    for sample in dropped:
        sample["command"] = replay_command(sample, settings, file, frame, view_layer, view)


def replay_command(sample, settings, file: str, frame: int, view_layer: str, view: str = "") -> str:
    """`python -m pt_engine replay …` with all settings that a path depends on, however they were set."""
    words = ["python", "-m", "pt_engine", "replay", file or "FILE.blend"]
    words += ["--pixel", f"{sample['x']},{sample['y']}", "--sample", str(sample["sample"])]
    words += ["--view", view] if view else []
    return shlex.join([*words, *settings_words(settings, frame, view_layer)])


def settings_words(settings, frame: int, view_layer: str) -> list[str]:
    """Options of the command line that give each sample of a render the path that it had."""
    words = ["--size", f"{settings.width}x{settings.height}", "--frame", str(frame)]
    words += ["--view-layer", view_layer, "--seed", str(settings.seed)]
    words += ["--integrator", settings.integrator, "--max-depth", str(settings.max_depth)]
    for name in PATH_SETTINGS:
        words += ["--set", f"{name}={getattr(settings, name)}"]
    return words


def headline(number: int) -> str:
    """How many there were."""
    return f"{number} non-finite or impossible (negative) samples were dropped, the first of them:"


def lines(dropped) -> list[str]:
    """One line for each: what happened where, and how to see it again."""
    return [
        f"pixel {s['x']},{s['y']}, sample {s['sample']}, bounce {s['bounce']}, {s['what']}{at(s)}:\n"
        f"    {s['command']}"
        for s in dropped
    ]


def at(sample) -> str:
    """` (material, object)` as far as they are known."""
    known = [sample[name] for name in ("material", "object") if sample[name]]
    return f" ({', '.join(known)})" if known else ""
