"""Cameras, one a file."""

from .base import Camera, CameraRays
from .make import make_camera

__all__ = ["Camera", "CameraRays", "make_camera"]
