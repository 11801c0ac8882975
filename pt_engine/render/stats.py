"""What a render tells about itself: the content of stats.json (see docs/stats.md)."""

from __future__ import annotations

import platform
import sys
from dataclasses import asdict
from importlib import metadata
from typing import Any

import numpy as np

from .. import __version__
from ..scene.scene import Scene
from .forecast import Prediction
from .ledger import Ledger
from .progressive import RenderResult
from .settings import RenderSettings

SCHEMA = "pt_engine.stats/3"


def statistics(
    scene: Scene, settings: RenderSettings, result: RenderResult, ledger: Ledger | None = None
) -> dict[str, Any]:
    """All that the render itself knows, ready for JSON; the caller adds `export` and `write` seconds."""
    progress = result.progress
    x0, y0, x1, y1 = settings.window
    pace = progress.camera_samples / max(result.seconds, 1e-9)
    return {
        "schema": SCHEMA,
        "settings": asdict(settings),
        "versions": versions(),
        "resolution": [x1 - x0, y1 - y0],
        "samples": progress.samples,
        "cancelled": result.cancelled,
        "seconds": {
            "export": 0.0,
            "build": scene.build_seconds,
            "render": result.seconds,
            "write": 0.0,
            "other": 0.0,
            "total": scene.build_seconds + result.seconds,
        },
        "camera_samples_per_second": pace,
        "rays": {kind: int(count) for kind, count in sorted(progress.rays.items())},
        "rays_per_second": sum(progress.rays.values()) / max(result.seconds, 1e-9),
        "peak_memory_bytes": peak_memory(),
        "nonfinite": {"count": progress.nonfinite_count, "samples": progress.nonfinite},
        "features": dict(scene.features),
        "ledger": ledger.books(scene) if ledger else None,
        "error": result.error(),
        "stopped_by": result.stopped_by,
        "prediction": foretold(progress.forecast.early(progress.camera_samples / progress.film.pixels)),
        "error_history": [
            [look.samples, look.seconds, look.relmse**0.5] for look in progress.forecast.history
        ],
        "coverage": [
            {"material": c.material, "node": c.node, "state": c.state, "effect": c.effect}
            for c in scene.coverage
        ],
        "textures": scene.textures.statistics(),
        "triangles": len(scene.geometry.records) - 1,
        "emitters": dict(scene.lights.description.counts),
    }


def foretold(prediction: Prediction | None) -> dict[str, Any] | None:
    """A prediction as an object; None if the render was too short for one."""
    return prediction and prediction._asdict()


def versions() -> dict[str, str]:
    """Of everything that can change an image."""
    found = {"pt_engine": __version__, "python": platform.python_version(), "numpy": np.__version__}
    for package in ("embreex", "OpenImageIO", "bpy"):
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = getattr(sys.modules.get(package), "__version__", "") or "unknown"
    found["platform"] = platform.platform()
    return found


def peak_memory() -> int:
    """Largest resident size of this process so far, in bytes; 0 where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak if sys.platform == "darwin" else peak * 1024)
