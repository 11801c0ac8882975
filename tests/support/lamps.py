"""Lamps to test with, and what is asked of every one of them."""

from __future__ import annotations

import numpy as np

from pt_engine.emitters.environment import ConstantEnvironment, EnvironmentMap, texel_directions
from pt_engine.emitters.lights import Lights
from pt_engine.emitters.triangle import TriangleEmitters
from pt_engine.scene.snapshot import LightData


def placed(x=0.0, y=0.0, z=2.0, tilt=0.0, scale=(1.0, 1.0, 1.0)):
    """Matrix of a lamp at (x, y, z), turned about X by `tilt`, scaled along its own axes."""
    c, s = np.cos(tilt), np.sin(tilt)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) * np.asarray(scale)
    matrix[:3, 3] = x, y, z
    return matrix


def lamp(kind, matrix=None, power=100.0, **settings):
    return LightData(kind, kind.lower(), placed() if matrix is None else matrix, power, **settings)


TILTED = placed(0.3, -0.4, 1.5, 0.4, (1.3, 0.8, 1.1))

SIZED = {
    "sphere": lamp("POINT", radius=0.4),
    "tiny sphere": lamp("POINT", radius=1e-4),
    "large sphere": lamp("POINT", radius=1.9),
    "enclosing sphere": lamp("POINT", radius=3.0),
    "soft point": lamp("POINT", radius=0.7, soft_falloff=True),
    "spot": lamp("SPOT", TILTED, radius=0.3, spot_size=1.4, spot_blend=0.5),
    "wide spot, narrow beam": lamp("SPOT", TILTED, radius=1.2, spot_size=0.6, spot_blend=0.5),
    "soft spot": lamp("SPOT", TILTED, radius=0.3, spot_size=1.4, spot_blend=0.5, soft_falloff=True),
    "sun": lamp("SUN", placed(tilt=0.5), power=3.0, angle=0.3),
    "thin sun": lamp("SUN", placed(tilt=0.5), power=3.0, angle=0.0093),
    "square": lamp("AREA", TILTED, size=(1.0, 1.0)),
    "rectangle": lamp("AREA", TILTED, shape="RECTANGLE", size=(2.0, 0.3)),
    "far rectangle": lamp("AREA", placed(z=60.0, x=5.0), shape="RECTANGLE", size=(2.0, 0.5)),
    "disk": lamp("AREA", TILTED, shape="DISK", size=(1.0, 1.0)),
    "ellipse": lamp("AREA", TILTED, shape="ELLIPSE", size=(1.5, 0.5)),
    "rectangle with spread": lamp("AREA", TILTED, shape="RECTANGLE", size=(2.0, 1.0), spread=np.radians(90)),
    "disk with spread": lamp("AREA", TILTED, shape="DISK", size=(1.5, 1.5), spread=np.radians(90)),
    "ellipse with spread": lamp("AREA", TILTED, shape="ELLIPSE", size=(2.5, 1.5), spread=np.radians(70)),
}

DELTA = {
    "point": lamp("POINT"),
    "delta spot": lamp("SPOT", spot_size=1.4, spot_blend=0.5),
    "delta sun": lamp("SUN", power=3.0),
    "parallel rectangle": lamp("AREA", shape="RECTANGLE", size=(2.0, 1.0), spread=0.0),
    "parallel disk": lamp("AREA", shape="DISK", size=(1.0, 1.0), spread=0.0),
}


def triangles(count=5, seed=3, varying=False):
    """Emissive triangles above the origin, about 0.1 sr each, some of them behind others."""
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0, 2 * np.pi, (count, 1)) + np.arange(3) * (2 * np.pi / 3)
    corners = 0.6 * np.stack([np.cos(turn), np.sin(turn), rng.uniform(-0.5, 0.5, (count, 3))], axis=-1)
    vertices = corners + rng.uniform((-1, -1, 1.5), (1, 1, 2.5), (count, 3))[:, None]
    radiance = rng.uniform(0.2, 3.0, (count, 3)).astype(np.float32)
    varies = np.full(count, varying) & (np.arange(count) % 2 == 0)
    return TriangleEmitters(vertices.astype(np.float32), radiance, varies, np.full(count, 1e-6, np.float32))


def smooth(d):
    """A sky without a sun."""
    return np.repeat((1.0 + 0.8 * d[2])[None], 3, axis=0)


def gradient(d):
    """A sky: bright above, with a small sun."""
    sky = np.maximum(0.2 + 0.8 * d[2], 0.05)
    sun = np.asarray((0.6, 0.0, 0.8), np.float32)
    sky = sky + 200.0 * ((d * sun[:, None]).sum(axis=0) > 0.997)
    return np.stack([sky, 0.8 * sky, 0.6 * sky]).astype(np.float32)


def environment_map(height=32, width=64, sky=gradient):
    return EnvironmentMap(sky(texel_directions(height, width))[1].reshape(height, width), sky)


def white(radiance=1.0):
    return ConstantEnvironment((radiance,) * 3)


def lights(*lamps, **more):
    return Lights(lamps, scene_radius=3.0, **more)


def points(n, position=(0.0, 0.0, 0.0)):
    return np.repeat(np.asarray(position, np.float32)[:, None], n, axis=1)


def up(n):
    return points(n, (0.0, 0.0, 1.0))


def floor(half=3.0):
    """Two triangles of a square at the origin: vertices, triangles."""
    vertices = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float32)
    vertices *= half
    return vertices, np.array([(0, 1, 2), (0, 2, 3)], np.int32)


def meet_triangles(emitters, o, d):
    """All (lane, triangle, t, |cos|) of rays with triangles, in float64."""
    o, d = o.astype(np.float64), d.astype(np.float64)
    for number, (a, b, c) in enumerate(emitters.vertices.astype(np.float64)):
        e1, e2 = b - a, c - a
        normal = np.cross(e1, e2)
        pv = np.cross(d.T, e2)
        det = pv @ e1
        tv = o.T - a
        u = (tv * pv).sum(axis=1) / det
        qv = np.cross(tv, e1)
        v = (d.T * qv).sum(axis=1) / det
        t = (qv @ e2) / det
        lanes = np.flatnonzero((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0))
        cos = np.abs(d.T @ normal)[lanes] / np.sqrt(normal @ normal)
        yield lanes, number, t[lanes], cos


def density(scene, emitters, o, d):
    """Density per solid angle with which `scene.sample` draws d, of all its emitters together."""
    pdf = scene.environment_pdf(d).astype(np.float64)
    for lanes, _, part, _ in scene.intersect(o, d, np.full(d.shape[1], np.inf, np.float32)):
        pdf[lanes] += part
    if emitters is not None:
        for lanes, number, t, cos in meet_triangles(emitters, o, d):
            index = np.full(lanes.size, number, np.intp)
            pdf[lanes] += scene.pdf_triangle(index, t.astype(np.float32), cos.astype(np.float32))
    return pdf


def irradiance(scene, n=200_000, position=(0.0, 0.0, 0.0), seed=7):
    """Estimate and standard error of the (red) irradiance on a plane that faces +Z, by light sampling."""
    u = np.random.default_rng(seed).random((3, n), np.float32)
    s = scene.sample(points(n, position), up(n), u)
    value = s.weight[0].astype(np.float64) * np.maximum(s.wo[2], 0.0)
    return value.mean(), value.std() / np.sqrt(n)
