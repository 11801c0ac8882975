"""Glass through which a transparent film shows: as smooth as the limit, by its roughness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make


def coverage(roughness: float, limit: float) -> float:
    """Mean alpha of a picture filled by a pane of glass before nothing."""
    glass = make.shader("BsdfGlass", "glass", Color=make.WHITE, Roughness=roughness, IOR=1.1)
    pane = make.box(4.0), np.diag([1.0, 1.0, 0.1, 1.0]), glass
    snapshot = make.scene([pane], make.orthographic((0, 0, 3), (0, 0, 0), 1.0), sky=make.world(1.0))
    result = make.rendered(
        replace(snapshot, clear_glass=limit), 8, samples=16, film_transparent=True, max_depth=4
    )
    return float(result.image()[..., 3].mean())


@pytest.mark.parametrize(
    ("roughness", "limit", "shows"),
    [(0.0, 0.0, True), (0.0, 0.1, True), (0.3, 0.35, True), (0.3, 0.25, False), (0.0, -1.0, False)],
)
def test_a_film_shows_through_glass_up_to_the_limit(roughness, limit, shows):
    """α = roughness² is 0.09 at 0.3: a limit of 0.25 is below that roughness and above that α."""
    alpha = coverage(roughness, limit)
    assert alpha < 0.2 if shows else alpha > 0.99
