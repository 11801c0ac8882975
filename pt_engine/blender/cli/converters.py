"""What words of the command line are turned into, or refused as."""

from __future__ import annotations

import argparse
from pathlib import Path


def whole(least: int):
    """A converter to int that refuses less than `least`."""

    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"{value} is less than {least}")
        return value

    return number


def positive(text: str) -> float:
    """A finite number of at least 0."""
    value = float(text)
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number of at least 0")
    return value


def pair(separator: str, least: int = 0):
    """A converter of `AxB` to two numbers."""

    def numbers(text: str) -> tuple[int, int]:
        first, found, second = text.partition(separator)
        if not (found and first.isdecimal() and second.isdecimal()):
            raise argparse.ArgumentTypeError(f"{text!r} is not like 640{separator}360")
        values = int(first), int(second)
        if min(values) < least:
            raise argparse.ArgumentTypeError(f"{text!r} has a number below {least}")
        return values

    return numbers


def path_ending(suffix: str):
    """A converter to a path with this ending."""

    def path(text: str) -> Path:
        if Path(text).suffix.lower() != f".{suffix}":
            raise argparse.ArgumentTypeError(f"{text!r} does not end with .{suffix}")
        return Path(text)

    return path


def assignment(text: str) -> tuple[str, str]:
    """`key=value` in two."""
    key, found, value = text.partition("=")
    if not (found and key):
        raise argparse.ArgumentTypeError(f"{text!r} is not like key=value")
    return key, value
