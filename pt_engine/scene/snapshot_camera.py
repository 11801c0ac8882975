"""The camera of a snapshot, and what changes while its shutter is open; `snapshot` passes them on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]


@dataclass(frozen=True)
class Stereo:
    """One eye of spherical stereo (see `cameras/spherical_stereo.py`).

    Attributes
    ----------
    offset : float
        From the middle, in metres; the left eye's is negative.
    convergence : float
        Distance where the eyes' rays meet; infinite for parallel ones.
    merge_from, merge_to : float
        Altitudes in radians between which the offset fades to 0; a `merge_to` of 0 switches that off.
    """

    offset: float
    convergence: float = float("inf")
    merge_from: float = 0.0
    merge_to: float = 0.0


@dataclass(frozen=True)
class CameraData:
    """The camera. `matrix` is camera to world without scale; it looks along its -Z, +Y up.

    Attributes
    ----------
    kind : str
        PERSP, ORTHO or PANO.
    frame : (4,) float
        left, right, bottom, top of the *full, uncropped* image: on the plane at distance 1 for PERSP,
        in metres for ORTHO, in the coordinates of the projection for PANO (see `cameras/panoramic.py`).
        Shift, sensor fit, pixel aspect and zoom are in here already.
    clip : tuple of 2
        Near and far along the view axis; from the eye in all directions for PANO.
    aperture_radius : float
        Of the thin lens, in metres; 0 for a pinhole.
    focus_distance : float
    panorama : str
        Blender's name of a PANO's projection: EQUIRECTANGULAR, FISHEYE_EQUISOLID ...
    fisheye_fov : float
        Full angle of a fisheye in radians; outside of it the image is empty.
    fisheye_polynomial : (5,) float
        k₀ to k₄ of FISHEYE_LENS_POLYNOMIAL.
    blades, blade_rotation, aperture_ratio :
        Polygonal aperture (0 blades: round), its rotation in radians, and its anamorphic ratio.
    stereo : Stereo or None
        Of a PERSP or PANO camera whose eyes turn with each ray. Eyes that stand still are in `matrix`.
    """

    kind: str
    matrix: Float64
    frame: tuple[float, float, float, float]
    clip: tuple[float, float] = (0.1, 1000.0)
    aperture_radius: float = 0.0
    focus_distance: float = 10.0
    blades: int = 0
    blade_rotation: float = 0.0
    aperture_ratio: float = 1.0
    panorama: str = ""
    fisheye_fov: float = float(np.pi)
    fisheye_polynomial: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    stereo: Stereo | None = None


@dataclass(frozen=True)
class InstanceMotion:
    """Placed meshes that move while the shutter is open, all known at equally many times.

    Attributes
    ----------
    instance : (M,) int32
        Rows of `Instances`.
    matrix : (M, K, 4, 4) float64
        Object to world at K ≥ 2 times, evenly from the shutter's opening to its closing.
    """

    instance: Int32
    matrix: Float64


@dataclass(frozen=True)
class MeshMotion:
    """A mesh that changes its shape while the shutter is open; its triangles stay.

    Attributes
    ----------
    mesh : int
        Index into `Snapshot.meshes`.
    vertices : (K, V, 3) float32
        At K ≥ 2 times, evenly from the shutter's opening to its closing.
    normals : (K, N, 3) float32 or None
        As many rows as `MeshData.normals` has; None where that is.
    """

    mesh: int
    vertices: Float32
    normals: Float32 | None = None


@dataclass(frozen=True)
class RoundMotion:
    """Curves or points that change their shape while the shutter is open; which belong together stays.

    Attributes
    ----------
    geometry : int
        Their number in `Instances.mesh`.
    points : (K, P, 3) float32
        At K ≥ 2 times, evenly from the shutter's opening to its closing.
    radius : (K, P) float32
    """

    geometry: int
    points: Float32
    radius: Float32


@dataclass(frozen=True)
class Motion:
    """What changes while the shutter is open. The snapshot itself is the middle of that time.

    Attributes
    ----------
    shutter : (n,) float32
        How far it is open at n ≥ 2 times, evenly from opening to closing, linear between them.
    instances : tuple of InstanceMotion
    meshes : tuple of MeshMotion
    rounds : tuple of RoundMotion
    cameras : tuple of CameraData
        The camera at K ≥ 2 times; () where it stands still.
    row_exposure : float
        What share of that time each row of the image is exposed: the top one from the opening on, the bottom
        one until the closing (a rolling shutter). 1: all rows all the time.
    """

    shutter: Float32
    instances: tuple[InstanceMotion, ...] = ()
    meshes: tuple[MeshMotion, ...] = ()
    cameras: tuple[CameraData, ...] = ()
    row_exposure: float = 1.0
    rounds: tuple[RoundMotion, ...] = ()
