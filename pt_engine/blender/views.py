"""The views of a stereoscopic or multi-view render, each seen through its own camera."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from ..scene.movement import beside
from ..scene.snapshot import CameraData, Snapshot, Stereo
from .export.camera import Eye, export_camera


def views(engine, depsgraph, snapshot: Snapshot, size: tuple[int, int]) -> Iterator[tuple[str, Snapshot]]:
    """Each view's name ("" where there is but one) and the snapshot as it is seen there.

    Geometry is exported once, diced as the scene's own camera asks; `engine` is told which view is at work.
    """
    scene = depsgraph.scene_eval
    render = scene.render
    if not render.use_multiview:
        yield "", snapshot
        return
    stereo = render.views_format == "STEREO_3D"
    for view in render.stereo_views if stereo else render.views:
        if not view.use:
            continue
        engine.active_view_set(view.name)
        camera = (engine.camera_override or scene.camera).evaluated_get(depsgraph)
        eye = eye_of(engine, camera, view) if stereo else None
        seen = export_camera(camera, render, size=size, unsupported=[], eye=eye)
        yield view.name, through(snapshot, seen)


def through(snapshot: Snapshot, camera: CameraData) -> Snapshot:
    """The snapshot seen by another camera, which moves along with the scene's own."""
    motion = snapshot.motion
    if motion is not None:
        motion = replace(motion, cameras=beside(motion.cameras, snapshot.camera, camera))
    return replace(snapshot, camera=camera, motion=motion)


def eye_of(engine, camera, view) -> Eye:
    """Where Blender puts one eye of a stereo camera."""
    spherical = engine.use_spherical_stereo(camera)
    return Eye(
        matrix=engine.camera_model_matrix(camera, use_spherical_stereo=spherical),
        shift_x=engine.camera_shift_x(camera, use_spherical_stereo=spherical),
        stereo=stereo_of(camera.data.stereo, view) if spherical else None,
    )


def stereo_of(settings, view) -> Stereo:
    """Spherical stereo as the camera's panel has it; only parallel and toed-in eyes are told apart there."""
    half = settings.interocular_distance / 2
    parallel = settings.convergence_mode == "PARALLEL"
    return Stereo(
        offset=-half if view.name == "left" else half,
        convergence=math.inf if parallel else settings.convergence_distance,
        merge_from=settings.pole_merge_angle_from if settings.use_pole_merge else 0.0,
        merge_to=settings.pole_merge_angle_to if settings.use_pole_merge else 0.0,
    )
