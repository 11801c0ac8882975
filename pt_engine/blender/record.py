"""What the last renders told about themselves: for the panels, for stats.json and for the command line."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..core.whole_file import write_whole
from ..scene.features import ON

SUMMED = ("export", "build", "render", "write", "other", "total")


class Observer:
    """Follows renders; the command line puts its own in place of this, which does nothing."""

    def wants(self, view: str) -> bool:
        """Whether a view is to be rendered ("" where there is but one)."""
        return True

    def takes_over(self, scene, settings, snapshot) -> bool:
        """Called when the scene is prepared; True if nothing is to be rendered."""
        return False

    def on_warning(self, headline: str, lines: list[str]) -> bool:
        """Something the user should know; True if this observer has told it."""
        return False

    def on_progress(self, progress) -> None:
        """After every unit of work."""

    def on_film(self, film) -> None:
        """The film of a render that is over."""

    def should_stop(self) -> bool:
        """Asked after every unit of work."""
        return False

    def on_failure(self, message: str) -> None:
        """The render has failed."""


@dataclass
class RenderRecord:
    """One frame: the statistics of each view layer, in the order rendered."""

    frame: int
    scene: str
    layers: dict[str, dict[str, Any]] = field(default_factory=dict)
    coverage: tuple[Any, ...] = ()
    failure: str = ""
    error: Any = None  # of the last layer: the picture of its standard errors, where somebody may look at it

    @property
    def has_holes(self) -> bool:
        """Whether a holdout may have cut holes into some layer."""
        return any(layer["features"]["holdouts"] == ON for layer in self.layers.values())

    def statistics(self) -> dict[str, Any]:
        """Of the first layer; with several, times and rays are sums and `layers` has each."""
        if not self.layers:
            return {}
        every = list(self.layers.values())
        merged = {**every[0], "frame": self.frame, "scene": self.scene}
        if len(every) > 1:
            merged["seconds"] = {k: sum(s["seconds"].get(k, 0.0) for s in every) for k in SUMMED}
            kinds = sorted({kind for s in every for kind in s["rays"]})
            merged["rays"] = {kind: sum(s["rays"].get(kind, 0) for s in every) for kind in kinds}
            merged["layers"] = self.layers
        return merged


class Session:
    """The state of this Blender: who follows, and what was rendered last."""

    observer = Observer()
    last: RenderRecord | None = None
    checked: RenderRecord | None = None


def close_times(seconds: dict[str, float], total: float) -> None:
    """Enter the whole time, and as `other` what of it no phase has had."""
    seconds["total"] = total
    phases = sum(seconds[name] for name in SUMMED if name not in ("other", "total"))
    seconds["other"] = max(0.0, total - phases)


def write_json(path: str | os.PathLike[str], statistics: dict[str, Any]) -> None:
    """Write the whole file or nothing: a reader never sees half of it."""
    write_whole(Path(path), json.dumps(finite(statistics), indent=2, allow_nan=False) + "\n")


def finite(value: Any) -> Any:
    """JSON has no infinity and no NaN: they become null."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    number = float(value)
    return number if abs(number) < float("inf") else None
