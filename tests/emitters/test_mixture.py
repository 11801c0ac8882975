"""Many lamps at once: each gives just what it gives alone, whatever the chance with which it is chosen."""

from __future__ import annotations

import numpy as np
from support.lamps import DELTA, SIZED, irradiance, lamp, lights, placed, points, up

LAMPS = {**SIZED, **DELTA}
UNSEEN = {"enclosing sphere"}  # lit points lie inside of it: its noise is that of a whole sphere


def test_each_lamp_gives_together_with_others_what_it_gives_alone():
    """E[f/(p·chance); chosen] = E[f/p]: the chance is in every weight. 5.5 standard errors of both."""
    names = [name for name in LAMPS if name not in UNSEEN]
    scene = lights(*(LAMPS[name] for name in names))
    n = 400_000
    s = scene.sample(points(n), up(n), np.random.default_rng(5).random((3, n), np.float32))
    value = s.weight[0].astype(np.float64) * np.maximum(s.wo[2], 0.0)
    total = np.bincount(s.emitter, value, minlength=scene.lamps) / n
    squares = np.bincount(s.emitter, value**2, minlength=scene.lamps) / n
    error = np.sqrt((squares - total**2) / n)
    alone = [irradiance(lights(LAMPS[name]), n=50_000) for name in names]
    # the scene sorts its lamps; equal kinds keep their order, so sums over kinds are compared
    for kind in ("POINT", "SPOT", "SUN", "AREA"):
        mine = [k for k, name in enumerate(names) if LAMPS[name].kind == kind]
        rows = [k for k, name in enumerate(scene.names) if name == kind.lower()]
        expected = sum(alone[k][0] for k in mine)
        allowed = 5.5 * np.hypot(
            np.sqrt((error[rows] ** 2).sum()), np.sqrt(sum(alone[k][1] ** 2 for k in mine))
        )
        assert abs(total[rows].sum() - expected) < allowed + 1e-4 * expected, kind


def test_two_suns_and_a_point_share_the_choice_exactly():
    """Without noise: two thin suns and a point above, E = E₁ + E₂ + Φ/4πh²."""
    suns = lamp("SUN", power=2.0, angle=1e-3), lamp("SUN", power=0.5, angle=1e-3)
    point = lamp("POINT", placed(z=2.0), 30.0)
    mean, error = irradiance(lights(*suns, point), n=100_000)
    expected = 2.5 + 30.0 / (4 * np.pi * 4)
    assert abs(mean - expected) < 5.5 * error + 1e-4
