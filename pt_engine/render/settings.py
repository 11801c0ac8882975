"""How to render: everything a user can set that is not part of the scene."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RenderSettings:
    """Settings of one render.

    Attributes
    ----------
    width, height : int
        Of the full image, in pixels.
    border : (x0, y0, x1, y1) or None
        Window of pixels to render, y up; None for all.
    samples : int
        Per pixel; 0 for no limit.
    first_sample : int
        Number of the first sample, so that a render can be made in parts and merged.
    seconds : float
        Time limit; 0 for none.
    target_error : float
        Relative error at which the render ends; 0 for none.
    target_percentile : float
        0: the target is for the image (√relMSE); else for so many per cent of its pixels.
    min_samples : int
        Per pixel, before the error decides anything.
    adaptive : bool
        Whether pixels stop early where their surroundings have little noise; `samples` is the most one gets.
    seed : int
    threads : int
        0 for one per core.
    integrator : str
        A name in `integrator.INTEGRATORS`.
    max_depth : int
        Longest path in edges: bounces < depth < vertices.
    rr_depth : int
        Depth from which Russian roulette may end a path.
    transparent_depth : int
        How many transparent surfaces a path or a shadow ray passes at most; they are not bounces.
    clamp_direct, clamp_indirect : float
        What a sample may bring at most of light after one bounce, and after more; 0 for all (unbiased).
    sampler : str
        A name in `core.samplers.SAMPLERS`.
    pixel_filter : str
        BLACKMAN_HARRIS, GAUSSIAN or BOX.
    filter_width : float
        In pixels.
    film_transparent : bool
        Whether the sky is left out of the image and of its alpha.
    half_buffers : bool
        Whether even and odd samples are kept apart, so that the halves can be written.
    lanes : int
        Size of a wavefront.
    """

    width: int
    height: int
    border: tuple[int, int, int, int] | None = None
    samples: int = 64
    first_sample: int = 0
    seconds: float = 0.0
    target_error: float = 0.0
    target_percentile: float = 0.0
    min_samples: int = 16
    adaptive: bool = False
    seed: int = 0
    threads: int = 0
    integrator: str = "path"
    max_depth: int = 14
    rr_depth: int = 4
    transparent_depth: int = 8
    clamp_direct: float = 0.0
    clamp_indirect: float = 0.0
    sampler: str = "sobol"
    pixel_filter: str = "BLACKMAN_HARRIS"
    filter_width: float = 1.5
    film_transparent: bool = False
    half_buffers: bool = False
    lanes: int = 3 << 14

    @property
    def window(self) -> tuple[int, int, int, int]:
        """The pixels to render: x0, y0, x1, y1."""
        return self.border or (0, 0, self.width, self.height)
