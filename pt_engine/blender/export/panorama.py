"""A panoramic camera's frame in the coordinates of its projection (see `cameras/panoramic.py`).

Shift moves the image by a share of its own width and height. Only the fisheyes that have a sensor know its
fit and the pixel aspect; all others fill the image, whatever its shape.
"""

from __future__ import annotations

import math

FULL_TURN = 2 * math.pi


def panorama_settings(camera, width: float, height: float) -> dict[str, object]:
    """Fields of `CameraData` for a panoramic camera and an image of width × height square pixels.

    A projection of a newer Blender becomes an equirectangular one; saying so is up to the caller.
    """
    kind = camera.panorama_type if camera.panorama_type in EDGES else "EQUIRECTANGULAR"
    left, right, bottom, top = EDGES[kind](camera, width, height)
    x, y = camera.shift_x * (right - left), camera.shift_y * (top - bottom)
    return {
        "panorama": kind,
        "frame": (left + x, right + x, bottom + y, top + y),
        "fisheye_fov": FULL_TURN if kind == "MIRRORBALL" else camera.fisheye_fov,
        "fisheye_polynomial": tuple(getattr(camera, f"fisheye_polynomial_k{n}") for n in range(5)),
    }


def of_sphere(camera, _width, _height):
    """Longitudes and latitudes."""
    return camera.longitude_min, camera.longitude_max, camera.latitude_min, camera.latitude_max


def of_cylinder(camera, _width, _height):
    """Longitudes, and heights over the radius."""
    low, high = camera.central_cylindrical_range_v_min, camera.central_cylindrical_range_v_max
    radius = camera.central_cylindrical_radius
    turn = camera.central_cylindrical_range_u_min, camera.central_cylindrical_range_u_max
    return *turn, low / radius, high / radius


def of_circle(camera, _width, _height):
    """The angles that fit."""
    half = camera.fisheye_fov / 2
    return -half, half, -half, half


def of_sensor(camera, width, height):
    """Millimetres on the sensor."""
    fit = camera.sensor_fit
    horizontal = width > height if fit == "AUTO" else fit == "HORIZONTAL"
    size = camera.sensor_height if fit == "VERTICAL" else camera.sensor_width
    half = 0.5 * size / (width if horizontal else height)
    return -half * width, half * width, -half * height, half * height


def of_lens(camera, width, height):
    """Lengths on the sensor over the focal length."""
    return tuple(edge / camera.fisheye_lens for edge in of_sensor(camera, width, height))


EDGES = {
    "EQUIRECTANGULAR": of_sphere,
    "EQUIANGULAR_CUBEMAP_FACE": lambda *_: (-math.pi / 4, math.pi / 4, -math.pi / 4, math.pi / 4),
    "MIRRORBALL": lambda *_: (-2.0, 2.0, -2.0, 2.0),
    "FISHEYE_EQUIDISTANT": of_circle,
    "FISHEYE_EQUISOLID": of_lens,
    "FISHEYE_LENS_POLYNOMIAL": of_sensor,
    "CENTRAL_CYLINDRICAL": of_cylinder,
}
