"""Animation for tests."""


def animate(owner, path, values, frames=(1, 2, 3)):
    """Keyframes with straight lines between them."""
    for frame, value in zip(frames, values, strict=True):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    for curve in curves_of(owner.id_data.animation_data.action):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    owner.id_data.update_tag()


def curves_of(action):
    """Its F-curves, in old Blenders and new ones."""
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]
