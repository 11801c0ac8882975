"""The shutter of the render settings: when it is open, and the frames to visit for it.

    open while |t − middle| < shutter / 2        middle = frame (CENTER), frame + shutter/2 (START), − (END)

An object with n motion steps is looked at 2ⁿ + 1 times, evenly from opening to closing, as in Cycles; what
has more steps is looked at at the others' times too.
"""

from __future__ import annotations

import math

import bpy
import numpy as np

from .bending import has_velocity

CURVE_ROWS = 256
MOVING_MODIFIERS = {
    "NODES", "CLOTH", "SOFT_BODY", "FLUID", "DYNAMIC_PAINT", "OCEAN", "WAVE", "BUILD", "EXPLODE",
    "MESH_CACHE", "MESH_SEQUENCE_CACHE", "PARTICLE_SYSTEM", "PARTICLE_INSTANCE",
}  # fmt: skip
MIDDLE = {"START": 0.5, "CENTER": 0.0, "END": -0.5}


class Shutter:
    """Within `with`, the scene is at the middle of the shutter's time; afterwards where it was.

    Parameters
    ----------
    scene : bpy.types.Scene
        Of the depsgraph.
    frame_set : callable (frame, subframe) or None
        Brings the depsgraph to another time. Without one, or where nothing can move, `on` is False and the
        scene is left alone.
    """

    def __init__(self, scene, frame_set) -> None:
        render = scene.render
        self.length = float(render.motion_blur_shutter)
        self.seconds = self.length * render.fps_base / render.fps
        self.on = bool(frame_set and render.use_motion_blur and self.length > 0.0 and may_move(scene))
        self._frame_set = frame_set
        self._at = self._now = (scene.frame_current, scene.frame_subframe)
        position = getattr(render, "motion_blur_position", None)
        if position is None:
            position = getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
        self.middle = sum(self._now) + MIDDLE.get(position, 0.0) * self.length
        self.openness = curve(render) if self.on else None
        self.row_exposure = row_exposure(scene)

    def __enter__(self) -> Shutter:
        try:
            if self.on:
                self.go(0.0)
        except BaseException:
            self.back()
            raise
        return self

    def __exit__(self, *failure) -> None:
        self.back()

    def go(self, place: float) -> None:
        """To a time between −1, the opening, and 1, the closing."""
        time = self.middle + place * self.length / 2
        frame = math.floor(time)
        self._set(frame, time - frame)

    def back(self) -> None:
        """To the frame where the scene was."""
        self._set(*self._now)

    def _set(self, *time) -> None:
        if self._at != time:
            self._at = ()  # where a failure leaves it is not known
            self._frame_set(*time)
            self._at = time


def curve(render):
    """(n,) float32 how far the shutter is open."""
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    points = mapping.curves[0]
    values = [mapping.evaluate(points, x) for x in np.linspace(0.0, 1.0, CURVE_ROWS)]
    return np.array(values[:1] * 2 if len(set(values)) == 1 else values, np.float32)


def row_exposure(scene) -> float:
    """`Motion.row_exposure`: Cycles' Rolling Shutter Duration."""
    cycles = getattr(scene, "cycles", None)
    if getattr(cycles, "rolling_shutter_type", "NONE") == "NONE":
        return 1.0
    return min(max(float(cycles.rolling_shutter_duration), 0.0), 1.0)


def may_move(scene) -> bool:
    """Whether the file has anything that changes with time."""
    handlers = bpy.app.handlers
    if len(bpy.data.actions) or scene.rigidbody_world is not None:
        return True
    if len(handlers.frame_change_pre) or len(handlers.frame_change_post):
        return True
    if len(bpy.data.cache_files) or len(bpy.data.movieclips):  # what constraints follow
        return True
    for owner in scene.objects:
        animations = [getattr(item, "animation_data", None) for item in (owner, owner.data)]
        if any(animation is not None and len(animation.drivers) for animation in animations):
            return True
        if any(modifier.type in MOVING_MODIFIERS for modifier in owner.modifiers) or has_velocity(owner.data):
            return True
    return False


def steps_of(owner, parent) -> int:
    """How often an object is looked at; 0 where its motion is not to be blurred."""
    settings = cycles_settings(owner, parent)
    if not all(getattr(item, "use_motion_blur", True) for item in settings):
        return 0
    return 2 ** max(1, *(getattr(item, "motion_steps", 1) for item in settings)) + 1


def deforms(owner, parent) -> bool:
    """Whether an object's change of shape is to be blurred."""
    return all(getattr(item, "use_deform_motion", True) for item in cycles_settings(owner, parent))


def cycles_settings(owner, parent) -> list:
    """Cycles' settings of an object and of its instancer (None without one), which both count."""
    return [getattr(item.original, "cycles", None) for item in (owner, parent) if item is not None]
