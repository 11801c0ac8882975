"""What an estimator cannot see, in a plain sentence."""

from __future__ import annotations

from collections.abc import Iterator

from ..render.settings import RenderSettings
from ..scene.features import ON
from ..scene.scene import Scene
from .contenders import ONE_BOUNCE
from .errors import Bias
from .fits import two_sided_p


def verdict(
    scene: Scene, settings: RenderSettings, reference_depth: int, found: Bias, as_base: bool = False
) -> str:
    """Why an estimate is biased and how much; "" where chance explains the difference.

    `as_base`: it cannot be told from the settings as set, which differ though they have no blind spot; so its
    own are not to blame.
    """
    if not found.significant:
        return ""
    causes = list(blind_spots(scene, settings, reference_depth))
    if as_base:
        why, what = "differs as the settings as set do", ""
    elif causes:
        why, what = " and ".join(causes), ", biased"
    else:
        why, what = "differs from the reference", f", biased, or {unlucky(scene)}"
    z = f"z = {found.z:.1f}"
    if two_sided_p(found.z) > two_sided_p(found.worst):
        z += f", {found.worst:.1f} in a part of the image"
    return f"{why}: {found.relative:+.1%} energy{what} ({z})".replace("-", "\N{MINUS SIGN}")


def unlucky(scene: Scene) -> str:
    """What z does not know of the noise."""
    rare = "rare bright samples are yet to come"
    if scene.features.get("motion blur") == ON:
        return f"{rare}, or moments of the shutter, which pixels share"
    return rare


def hittable(scene: Scene) -> bool:
    """Whether some light can be seen in a mirror: what has no size cannot, whoever looks."""
    return any(scene.features.get(name) == ON for name in ("environment", "lamps met by rays", "mesh lights"))


def blind_spots(scene: Scene, settings: RenderSettings, reference_depth: int) -> Iterator[str]:
    """The light paths of this scene that no sample of the estimator can be."""
    features = scene.features
    if settings.integrator == "direct_emitter" and features.get("ideal specular") == ON and hittable(scene):
        yield "emitter sampling misses the mirror"
    if settings.integrator == "direct_bsdf" and features.get("Dirac lamps") == ON:
        yield "BSDF sampling cannot hit lamps without a size"
    if settings.integrator in ONE_BOUNCE and reference_depth > 2:
        yield "one bounce misses indirect light"
    if settings.clamp_direct or settings.clamp_indirect:
        yield "clamping takes the energy of bright samples"
    if settings.integrator not in ONE_BOUNCE and settings.max_depth < reference_depth:
        yield f"depth {settings.max_depth} misses longer paths"
