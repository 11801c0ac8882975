"""What a person sees: a bar or occasional lines on stderr, one closing line on stdout."""

from __future__ import annotations

import signal
import sys
from typing import Self

from ...report.error_picture import error_picture
from ...report.tables import plural
from ..record import Observer
from ..words import count, doubts, duration, estimated_error, status

BAR_INTERVAL = 0.1  # seconds
FIRST_LINE, LINE_GROWTH = 5.0, 1.5
BAR_WIDTH = 30


class Interruption:
    """Ctrl-C inside: the first one ends the work in order, a second one ends at once."""

    def __init__(self) -> None:
        self.interrupted = False

    def should_stop(self) -> bool:
        """Whether there was one."""
        return self.interrupted

    def __enter__(self) -> Self:
        try:
            self.previous = signal.signal(signal.SIGINT, self._interrupt)
        except ValueError:  # not in the main thread
            self.previous = None
        return self

    def __exit__(self, *_) -> None:
        if self.previous is not None:
            signal.signal(signal.SIGINT, self.previous)

    def _interrupt(self, number, frame) -> None:
        self.interrupted = True
        signal.signal(signal.SIGINT, signal.default_int_handler)


class Terminal(Interruption, Observer):
    """Follows a render on stderr, and stops it at Ctrl-C."""

    def __init__(self, quiet: bool = False, bar: bool = False) -> None:
        super().__init__()
        self.error_picture = None
        self.quiet = quiet
        self.bar = (bar or sys.stderr.isatty()) and not quiet
        self.next_told = 0.0 if self.bar else FIRST_LINE
        self.drawn = False
        self.samples = 0
        self.failure = ""

    def on_warning(self, headline: str, lines: list[str]) -> bool:
        if not self.quiet:
            print(headline, *lines, sep="\n  ", file=sys.stderr)
        return True

    def on_progress(self, progress) -> None:
        self.samples = progress.samples
        if self.quiet or progress.elapsed < self.next_told:
            return
        if self.bar:
            self.next_told = progress.elapsed + BAR_INTERVAL
            self.drawn = True
            done = round(progress.fraction * BAR_WIDTH)
            bar = "#" * done + "." * (BAR_WIDTH - done)
            line = f"\r[{bar}] {progress.fraction:4.0%}  {status(progress)}\x1b[K"
            print(line, end="", file=sys.stderr, flush=True)
        else:
            self.next_told = progress.elapsed * LINE_GROWTH
            print(f"{progress.fraction:4.0%}  {status(progress)}", file=sys.stderr, flush=True)

    def on_film(self, film) -> None:
        self.error_picture = error_picture(film)

    def on_failure(self, message: str) -> None:
        self.failure = message

    def __exit__(self, *error) -> None:
        super().__exit__(*error)
        if self.drawn:
            print(file=sys.stderr)


def closing_line(written: str, statistics) -> str:
    """What was written; time, samples, speed and estimated error of a finished render."""
    seconds = statistics["seconds"]
    width, height = statistics["resolution"]
    error = estimated_error(statistics["error"])
    parts = [
        f"{written}: {width}x{height}",
        plural(statistics["samples"], "sample"),
        f"{duration(seconds['total'])} (render {duration(seconds['render'])})",
        f"{count(statistics['rays_per_second'])} rays/s",
        f"estimated error {error}" if error else "estimated error unknown",
    ]
    parts += [doubt[:1].lower() + doubt[1:] for doubt in doubts(statistics["error"])]
    if dropped := statistics["nonfinite"]["count"]:
        parts.append(f"{dropped} non-finite samples dropped")
    return ", ".join(parts)
