"""What images are measured against: a given file, or a long render of our own that is kept for the next time.

Our own reference is made with independent samples, another seed and the whole estimator, until its relative
error is small enough or its time is over. A kept one that is not good enough yet is continued: films of
disjoint samples merge exactly.
"""

from __future__ import annotations

import hashlib
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..render.film import Film
from ..render.film_file import load_film, save_film
from ..render.progressive import film_key, render
from ..render.settings import RenderSettings
from ..scene.scene import Scene
from ..scene.snapshot import Snapshot
from ..scene.snapshot_io import save_snapshot
from .errors import Picture
from .pictures import picture_of
from .runs import Asked, colours, never, plain

OTHER_SEED = 0x2545F491
FIRST_STEP, LARGEST_STEP = 8, 256  # samples


@dataclass
class Reference:
    """A picture, bottom row first, and where it is from, in words."""

    picture: Picture
    origin: str
    error: float | None  # relative RMS of its own noise, None where nobody knows


def given(path: Path, width: int, height: int) -> Reference:
    """A reference from a file.

    Raises
    ------
    ValueError
        It can't be read or has another size.
    """
    picture = picture_of(path)
    found = picture.mean.shape[1], picture.mean.shape[0]
    if found != (width, height):
        raise ValueError(f"{path} has {found[0]}x{found[1]} pixels, the render {width}x{height}")
    variance = None if picture.variance is None else picture.variance[::-1]
    return Reference(Picture(picture.mean[::-1], variance), str(path), None)


def made(
    scene: Scene,
    settings: RenderSettings,
    wanted: float,
    seconds: float,
    cache: Path | None = None,
    should_stop: Asked = never,
) -> Reference:
    """Render until the relative RMS error is `wanted` or so many core `seconds` are over.

    `cache` is the file where the film is kept, also of one that somebody has stopped.
    """
    settings = of_reference(settings)
    found, ended = kept(cache, film_key(settings)), time.process_time() + seconds
    film = found
    if film is None:
        first = render(scene, replace(settings, samples=FIRST_STEP), should_stop=should_stop)
        film, cache = first.film, None if first.cancelled else cache
    while relative_error(film) > wanted and time.process_time() < ended:
        taken = sum(count for _, count in film.ranges)
        step = replace(settings, first_sample=taken, samples=min(taken, LARGEST_STEP))
        result = render(scene, step, should_stop=lambda: time.process_time() >= ended or should_stop())
        if result.cancelled:  # its last pass is not whole
            break
        film.merge(result.film)
    if cache is not None:
        keep(film, cache)
    samples = int(np.max(film.counts()))
    origin = f"path tracing, {samples} independent samples" + (
        ", continued from a kept film" if found else ""
    )
    picture = Picture(colours(film.image()), film.variance_of_mean())
    return Reference(picture, origin, relative_error(film))


def of_reference(settings: RenderSettings) -> RenderSettings:
    """The whole estimator with numbers that no contender uses, and whose noise is exactly known."""
    seed = settings.seed ^ OTHER_SEED
    return replace(
        plain(settings),
        integrator="path",
        sampler="independent",
        clamp_direct=0.0,
        clamp_indirect=0.0,
        seed=seed,
    )


def relative_error(film: Film) -> float:
    """Relative RMS of a film's noise; infinite where it is not known."""
    relmse = film.error()["relmse"]
    return float(np.sqrt(relmse)) if isinstance(relmse, float) else float("inf")


def kept(path: Path | None, key: str) -> Film | None:
    """An earlier reference; None if there is none of use."""
    if path is None or not path.exists():
        return None
    try:
        film = load_film(path)
    except (OSError, ValueError):
        return None
    return film if film.key == key else None


def keep(film: Film, path: Path) -> None:
    """Write it for the next time; a full or read-only disk costs no comparison."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_film(film, path)
    except OSError:
        pass


def cache_file(snapshot: Snapshot, settings: RenderSettings) -> Path:
    """Where the film of this very scene and these settings is kept."""
    digest = hashlib.sha256(film_key(of_reference(settings)).encode())
    save_snapshot(snapshot, Digest(digest))  # type: ignore[arg-type]
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    return Path(base).expanduser() / "pt_engine" / "references" / f"{digest.hexdigest()[:32]}.npz"


class Digest:
    """A stream that keeps only the hash of what is written; it can't seek, so a zip streams into it."""

    def __init__(self, digest: hashlib._Hash) -> None:
        self._digest, self._position = digest, 0

    def write(self, content: bytes) -> int:
        self._digest.update(content)
        self._position += len(content)
        return len(content)

    def flush(self) -> None:
        """Nothing waits."""

    def tell(self) -> int:
        raise OSError("a stream")
