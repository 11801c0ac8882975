"""Raised normals: mirror directions end up just above the surface, valid normals stay."""

import numpy as np

from pt_engine.core.vectors import dot
from pt_engine.scene.raised_normal import raised_normal

rng = np.random.default_rng(5)


def unit(n):
    v = rng.normal(size=(3, n)).astype(np.float32)
    return v / np.linalg.norm(v, axis=0)


def test_mirror_directions_reach_the_limit():
    """R'·ng = min(0.9 wi·ng, 0.01) where R·ng was less; n' is unit and in the plane of n and ng."""
    ng, wi, n = unit(20_000), unit(20_000), unit(20_000)
    wi *= np.copysign(1, dot(wi, ng))
    n *= np.copysign(1, dot(n, ng))
    raised = raised_normal(ng, wi, n)
    limit = np.minimum(0.9 * dot(wi, ng), 0.01)
    before, after = (2 * dot(m, wi) * dot(m, ng) - dot(wi, ng) for m in (n, raised))
    low = before < limit
    assert low.sum() > 1000
    np.testing.assert_array_equal(raised[:, ~low], n[:, ~low])
    np.testing.assert_allclose(after[low], limit[low], atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(raised, axis=0), 1, atol=1e-4)
    np.testing.assert_allclose(dot(np.cross(n, ng, axis=0), raised)[low], 0, atol=1e-4)


def test_the_true_normal_is_kept():
    ng, wi = unit(100), unit(100)
    wi *= np.copysign(1, dot(wi, ng))
    np.testing.assert_array_equal(raised_normal(ng, wi, ng), ng)
