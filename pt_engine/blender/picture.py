"""The picture that Blender shows and writes: a render result that is always ended."""

from __future__ import annotations

import bpy
import numpy as np

FIRST_INTERVAL = 0.5  # seconds until the second showing
GROWTH = 1.35  # each interval's ratio to the one before
LONGEST_INTERVAL = 20.0


class Picture:
    """The render result of one view layer, and of one of its views where it has several.

    Use as a context manager: it is ended on the way out, and cancelled where an exception leaves.
    """

    def __init__(self, engine, layer: str, size: tuple[int, int], view: str = "") -> None:
        self.engine = engine
        self.layer = layer
        self.view = view
        self.size = size
        self.shown_at = -1.0
        self.interval = FIRST_INTERVAL
        self.watched = not bpy.app.background

    def __enter__(self) -> Picture:
        self.result = self.engine.begin_result(0, 0, *self.size, layer=self.layer, view=self.view)
        self.passes = {p.name: p for p in self.result.layers[0].passes}
        return self

    def __exit__(self, kind, error, trace) -> None:
        self.engine.end_result(self.result, cancel=kind is not None)

    def show(self, image: np.ndarray) -> None:
        """Hand over (height, width, 4) float32, bottom row first."""
        self.fill("Combined", image)
        self.engine.update_result(self.result)

    def fill(self, name: str, image: np.ndarray) -> None:
        """Put an image into a pass; what is undefined there (one sample has no error) is 0."""
        values = np.nan_to_num(np.ascontiguousarray(image, np.float32))
        self.passes[name].rect.foreach_set(values.reshape(-1))

    def show_progress(self, progress) -> None:
        """Show the first pass at once, later ones at growing intervals; nothing where nobody looks."""
        if not self.watched or progress.samples < 1:
            return
        if self.shown_at < 0 or progress.elapsed - self.shown_at >= self.interval:
            if self.shown_at >= 0:
                self.interval = min(self.interval * GROWTH, LONGEST_INTERVAL)
            self.show(progress.image())
            self.shown_at = progress.elapsed
