"""What an integrator is, and the registry that panels and the command line choose from.

A user's own file adds one: subclass `Integrator`, give it a name and a label, write `sample`. Rays,
passes, film and statistics are done for it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .clamping import clamp_of

if TYPE_CHECKING:
    from ..scene.scene import Scene
    from ..scene.wave import Rays
    from .dimensions import LaneSampler
    from .settings import RenderSettings

Float32 = NDArray[np.float32]

INTEGRATORS: dict[str, type[Integrator]] = {}


class Integrator(ABC):
    """Estimates the radiance that arrives along camera rays.

    Attributes
    ----------
    name : str
        Identifier on the command line; a subclass that has one is registered under it.
    label, description : str
        What the panel shows.
    signed : bool
        Whether its estimates may be below 0 by right; else such samples are dropped and reported, where
        no light of the scene is negative.
    combines : bool
        Whether all light that emitter sampling finds is found by BSDF sampling too, both weighted by MIS:
        emitters then leave what is dim and all around to BSDFs.
    waves : int
        How many wavefronts of `lanes` rays it is best given at once, to take one after the other.
    """

    name: ClassVar[str] = ""
    label: ClassVar[str] = ""
    description: ClassVar[str] = ""
    signed: ClassVar[bool] = False
    combines: ClassVar[bool] = False
    waves: ClassVar[int] = 1

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("name"):
            INTEGRATORS[cls.name] = cls

    def __init__(self, settings: RenderSettings) -> None:
        self.max_depth = settings.max_depth
        self.rr_depth = settings.rr_depth
        self.transparent_depth = settings.transparent_depth
        self.lanes = settings.lanes
        self.clamp = clamp_of(settings)

    @abstractmethod
    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        """One estimate of the radiance along each ray.

        Parameters
        ----------
        scene : Scene
        rays : Rays
            N camera rays.
        sampler : LaneSampler
            The random numbers of these N lanes.

        Returns
        -------
        radiance : (3, N) float32, W·m⁻²·sr⁻¹
        """
