"""Faults that are put into a small scene, and what its statistics say of them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pt_engine.bsdfs import conductor
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.render.stats import statistics
from pt_engine.scene.prepare import prepare

from . import scenes as make

UP = np.eye(4)
GLOSSY = make.shader("BsdfGlossy", "brass", {"distribution": "GGX"}, Color=make.WHITE, Roughness=0.3)


def settings(**more):
    chosen = {"samples": 16, "threads": 2, "pixel_filter": "BOX", "filter_width": 1.0, "max_depth": 4}
    return RenderSettings(12, 8, **(chosen | more))


def snapshot(lamps=(), sky=0.5, material=GLOSSY):
    """A brass ball on a grey floor beside a small shining square."""
    objects = [
        (make.quad(8.0), UP, make.diffuse(0.5, "floor")),
        (make.sphere(0.6, 16), make.translation(0, 0, 0.6), material),
        (make.quad(0.5), make.translation(0.9, -0.3, 0.4), make.emission(2.0, "tube")),
    ]
    return make.scene(objects, make.perspective((0, -4, 2), (0, 0, 0.4), 0.35), lamps, make.world(sky))


def told(scene, **more):
    """Statistics of a render."""
    how = settings(**more)
    return statistics(scene, how, render(scene, how))["nonfinite"]


def poisoned(where, value, lanes):
    """A stand-in for `conductor` whose `where` gives `value` in lanes that `lanes(u or wo)` picks."""

    def sample(params, wi, u0, u1, u2):
        s = conductor.sample(params, wi, u0, u1, u2)
        if where == "sample":
            weight = np.broadcast_to(s.weight, (3, s.wo.shape[1])).copy()
            weight[:, lanes(u1)] = value
            s = s._replace(weight=weight)
        return s

    def eval_pdf(params, wi, wo):
        f, pdf = conductor.eval_pdf(params, wi, wo)
        if where == "eval":
            f = np.broadcast_to(f, (3, wo.shape[1])).copy()
            f[:, lanes(wo[0])] = value
        return f, pdf

    return SimpleNamespace(
        sample=sample, eval_pdf=eval_pdf, albedo=conductor.albedo, SPECULAR=True, __name__="poisoned"
    )


def with_bsdf(model, scene=None):
    """The scene, or another one, with its brass scattered by `model`."""
    scene = prepare(snapshot()) if scene is None else scene
    batch = next(b for b in scene.materials.batches if "brass" in names_of(scene, b))
    closures = batch.closures
    batch.closures = lambda lanes: [SimpleNamespace(**parts(c) | {"bsdf": model}) for c in closures(lanes)]
    return scene


def parts(closure):
    return {k: getattr(closure, k) for k in ("bsdf", "params", "weight", "normal", "tangent", "base")}


def names_of(scene, batch):
    number = scene.materials.batches.index(batch)
    return {scene.material_names[m] for m in np.flatnonzero(scene.materials.batch_of == number)}
