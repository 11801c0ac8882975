"""A prepared scene through another camera: stereoscopic and multi-view renders build it once."""

from __future__ import annotations

import copy
from collections.abc import Iterable

from ..cameras import make_camera
from ..core.view import View
from ..nodes.compile import Materials
from ..nodes.world import LightProgram, WorldProgram
from .features import features
from .scene import Scene
from .snapshot import CameraData, Snapshot


def through(scene: Scene, snapshot: Snapshot) -> Scene | None:
    """The scene as `prepare` would make it of `snapshot`, which differs in its camera alone.

    None where the scene holds what was made for its own camera (`made_for_one_view`).
    """
    if scene.of_one_view:
        return None
    other = copy.copy(scene)
    other.camera = make_camera(snapshot.camera, scene.geometry.origin)
    other.view = view_of(snapshot.camera)
    other.build_seconds = 0.0
    if scene.alone is not None:
        other.alone = through(scene.alone, snapshot)
    if scene.slices is not None:
        other.slices = scene.slices.through(other, snapshot)
    other.features = features(snapshot, other, scene.film_transparent)
    return other


def view_of(camera: CameraData) -> View:
    """The camera's space and image."""
    return View(camera.kind, camera.matrix, camera.frame, camera.panorama, camera.fisheye_polynomial)


def made_for_one_view(materials: Materials, world: WorldProgram, lamps: Iterable[LightProgram]) -> bool:
    """Whether programs that run beforehand ask where something is in the camera's image or space.

    Those are the world's and lamps', whose light is tabulated, and displacements.
    """
    needs = set(world.needs).union(*(lamp.batch.needs for lamp in lamps if lamp.batch is not None))
    for displacement in materials.displacement.values():
        needs |= displacement.reads()
    return "view" in needs
