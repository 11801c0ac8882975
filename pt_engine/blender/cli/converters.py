"""What words of the command line are turned into, or refused as."""

from __future__ import annotations

import argparse
import os
from pathlib import Path


def whole(least: int, most: int | None = None):
    """A converter to int that refuses less than `least` and more than `most`."""

    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"{value} is less than {least}")
        if most is not None and value > most:
            raise argparse.ArgumentTypeError(f"{value} is more than {most}")
        return value

    return number


def positive(text: str) -> float:
    """A finite number of at least 0."""
    value = float(text)
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number of at least 0")
    return value


def pair(separator: str, least: int, most: int):
    """A converter of `AxB` to two numbers from `least` to `most`."""

    def numbers(text: str) -> tuple[int, int]:
        first, found, second = text.partition(separator)
        if not (found and first.isdecimal() and second.isdecimal()):
            raise argparse.ArgumentTypeError(f"{text!r} is not like 640{separator}360")
        values = int(first), int(second)
        if min(values) < least:
            raise argparse.ArgumentTypeError(f"{text!r} has a number below {least}")
        if max(values) > most:
            raise argparse.ArgumentTypeError(f"{text!r} has a number above {most}")
        return values

    return numbers


def path_ending(suffix: str, *, or_dash: bool = False):
    """A converter to a path with this ending, so that no output takes the place of another or of a .blend."""

    def path(text: str) -> Path:
        if or_dash and text == "-":
            return Path(text)
        if Path(text).suffix.lower() != f".{suffix}":
            raise argparse.ArgumentTypeError(f"{text!r} does not end with .{suffix}")
        return file(text)

    return path


def file(text: str) -> Path:
    """A path; Blender's own way to say "beside the .blend" means something else to everyone but Blender."""
    if text.startswith("//") and os.name == "posix":
        raise argparse.ArgumentTypeError(f"{text!r}: name the folder; // is understood by Blender alone")
    return Path(text)


def assignment(text: str) -> tuple[str, str]:
    """`key=value` in two."""
    key, found, value = text.partition("=")
    if not (found and key):
        raise argparse.ArgumentTypeError(f"{text!r} is not like key=value")
    return key, value
