"""What kind of ray found a point: bits that follow Blender's Light Path node."""


class RayKind:
    """Bits of a lane's `ray_kind`."""

    CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, SHADOW, REFLECTION, SINGULAR, VOLUME = 1, 2, 4, 8, 16, 32, 64, 128
