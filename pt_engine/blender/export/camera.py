"""The camera: its framing, lens and place.

The framing follows Blender's own rules (sensor fit, pixel aspect, shift in units of the fitted side), so
`frame` projects exactly as `bpy_extras.object_utils.world_to_camera_view` does. The thin lens:

    aperture radius = lens / (2 · f-stop)   perspective (lens in metres),   1 / (2 · f-stop)   orthographic
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...scene.snapshot import CameraData, Stereo
from .failure import ExportError
from .panorama import panorama_settings

MILLIMETRE = 1e-3


class Eye(NamedTuple):
    """One eye of a stereo camera: its place, its shift, and what turns with each ray (or None)."""

    matrix: Any
    shift_x: float
    stereo: Stereo | None


def export_camera(camera_object, render, *, size=None, unsupported, eye=None) -> CameraData:
    """The camera of an evaluated object.

    Parameters
    ----------
    camera_object : bpy.types.Object
        Evaluated, of type CAMERA.
    render : bpy.types.RenderSettings
        Resolution and pixel aspect.
    size : (width, height), optional
        Full image size in pixels, where it isn't the render settings'.
    unsupported : list
        What the engine can't do is appended as (where, what, effect).
    eye : Eye, optional
        Of a stereo camera; the place in focus is the camera's own.

    Raises
    ------
    ExportError
        The camera is an OSL shader.
    """
    camera = camera_object.data
    if camera.type == "CUSTOM":
        raise ExportError(
            f"camera {camera_object.name!r} is an OSL shader, which this engine can't run: "
            "choose another lens type in the camera's panel"
        )
    matrix = np.array(camera_object.matrix_world, np.float64)
    radius, focus = thin_lens(camera, matrix)
    if eye is not None:
        matrix = np.array(eye.matrix, np.float64)
    ratio = pixel_ratio(render, size)
    kind = camera.type
    shift = camera.shift_x if eye is None else eye.shift_x
    view = (
        panorama_settings(camera, *ratio) if kind == "PANO" else {"frame": image_frame(camera, shift, *ratio)}
    )
    where = f"Camera {camera_object.name}"
    if kind == "PANO" and view["panorama"] != camera.panorama_type:
        unsupported.append((where, f"panorama {camera.panorama_type}", "rendered as an equirectangular one"))
    return CameraData(
        kind=kind,
        matrix=without_scale(matrix),
        clip=(camera.clip_start, camera.clip_end),
        aperture_radius=radius,
        focus_distance=focus,
        blades=camera.dof.aperture_blades,
        blade_rotation=camera.dof.aperture_rotation,
        aperture_ratio=camera.dof.aperture_ratio,
        stereo=None if eye is None else eye.stereo,
        **view,
    )


def pixel_ratio(render, size=None) -> tuple[float, float]:
    """Width and height of the full image in units of a square pixel."""
    width, height = size or full_size(render)
    return width * render.pixel_aspect_x, height * render.pixel_aspect_y


def full_size(render) -> tuple[int, int]:
    """Pixels of the full, uncropped image."""
    percentage = render.resolution_percentage
    return (
        max(render.resolution_x * percentage // 100, 1),
        max(render.resolution_y * percentage // 100, 1),
    )


def image_frame(camera, shift_x: float, width: float, height: float) -> tuple[float, float, float, float]:
    """Left, right, bottom, top: at distance 1 for a perspective, in metres for an orthographic camera."""
    fit = camera.sensor_fit
    horizontal = width > height if fit == "AUTO" else fit == "HORIZONTAL"
    fitted = width if horizontal else height
    if camera.type == "ORTHO":
        extent = camera.ortho_scale
    else:
        sensor = camera.sensor_height if fit == "VERTICAL" else camera.sensor_width
        extent = sensor / camera.lens
    half_width, half_height = 0.5 * extent * width / fitted, 0.5 * extent * height / fitted
    x, y = shift_x * extent, camera.shift_y * extent
    return x - half_width, x + half_width, y - half_height, y + half_height


def thin_lens(camera, matrix) -> tuple[float, float]:
    """Aperture radius (0 without depth of field) and distance of the plane in focus, metres."""
    dof = camera.dof
    if not dof.use_dof:
        return 0.0, dof.focus_distance
    lens = 1.0 if camera.type == "ORTHO" else camera.lens * MILLIMETRE
    return lens / (2.0 * max(dof.aperture_fstop, 1e-5)), focus_distance(dof, matrix)


def focus_distance(dof, matrix) -> float:
    """Along the view axis to the focus object (or its bone), else the distance in the panel."""
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    place = target.matrix_world
    if dof.focus_subtarget and target.pose and dof.focus_subtarget in target.pose.bones:
        place = place @ target.pose.bones[dof.focus_subtarget].matrix
    axis = matrix[:3, 2] / max(np.linalg.norm(matrix[:3, 2]), 1e-30)
    return float(abs(axis @ (matrix[:3, 3] - np.array(place, np.float64)[:3, 3])))


def without_scale(matrix):
    """The matrix with its axes at length 1."""
    result = matrix.copy()
    length = np.linalg.norm(result[:3, :3], axis=0)
    result[:3, :3] /= np.maximum(length, 1e-30)
    return result
