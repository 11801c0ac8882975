"""Formulas of scattering, light, sampling and statistics, each as it is and as it is not: `mutations`."""

from __future__ import annotations

from typing import NamedTuple


class Mutation(NamedTuple):
    """A change of one place of one file below pt_engine/, and the tests that are to fail then."""

    name: str
    file: str
    right: str
    wrong: str
    tests: str


FORMULAS = (
    Mutation(
        "Lambert's value without its cosine",
        "bsdfs/diffuse.py",
        "    pdf = np.maximum(cos_o, 0) * INV_PI\n    return pdf[np.newaxis], pdf",
        "    pdf = (cos_o > 0) * INV_PI\n    return pdf[np.newaxis], pdf",
        "tests/bsdfs/test_diffuse.py",
    ),
    Mutation(
        "refraction with the index upside down",
        "bsdfs/interface.py",
        "inverse: Float32 = 1.0 / eta",
        "inverse: Float32 = 1.0 * eta",
        "tests/bsdfs/test_dielectric.py",
    ),
    Mutation(
        "refraction's Jacobian with η, not η²",
        "bsdfs/interface.py",
        "2.0 * (side_eta * side_eta)",
        "2.0 * side_eta",
        "tests/bsdfs/test_dielectric.py",
    ),
    Mutation(
        "Fresnel's p-polarised part with η, not η²",
        "bsdfs/fresnel.py",
        "eta2 = eta * eta",
        "eta2 = eta * 1.0",
        "tests/bsdfs/test_fresnel.py",
    ),
    Mutation(
        "GGX without its square",
        "bsdfs/microfacet.py",
        "        e *= e\n",
        "",
        "tests/bsdfs/test_conductor.py",
    ),
    Mutation(
        "masking with both directions swapped",
        "bsdfs/microfacet.py",
        "zo * (zi + ti)",
        "zi * (zo + to)",
        "tests/bsdfs/test_conductor.py",
    ),
    Mutation(
        "visible normals from a cap that is not filled evenly",
        "bsdfs/microfacet.py",
        "q = u2 * above",
        "q = u2 * u2 * above",
        "tests/bsdfs/test_conductor.py",
    ),
    Mutation(
        "power heuristic with linear weights",
        "render/path_state.py",
        "ratio *= ratio",
        "ratio *= 1",
        "tests/render/test_replay_text.py",
    ),
    Mutation(
        "roulette that does not divide by its chance",
        "render/survivors.py",
        "survives /= q",
        "survives /= 1",
        "tests/render/test_survivors.py",
    ),
    Mutation(
        "paths one edge too long",
        "render/survivors.py",
        "path.bounces >= limit.max_depth - 1",
        "path.bounces >= limit.max_depth",
        "tests/render/test_closed_forms.py",
    ),
    Mutation(
        "rays that leave on the viewer's side only",
        "scene/surface.py",
        "np.copysign(self.bound, vectors.dot(self.ng, wo)) * self.ng",
        "self.bound * self.ng",
        "tests/hard_cases tests/render/test_closed_forms.py",
    ),
    Mutation(
        "variance over n, not n − 1",
        "render/film_moments.py",
        "np.maximum(n - 1.0, 1.0)",
        "np.maximum(n, 1.0)",
        "tests/render/test_film.py",
    ),
    Mutation(
        "a mesh light's solid angle without its cosine",
        "emitters/triangle.py",
        "    projected: Float32 = np.abs(through)\n    projected /= distance",
        "    projected: Float32 = np.abs(through)",
        "tests/emitters/test_closed_forms.py",
    ),
    Mutation(
        "a ball of light found with half its density",
        "emitters/point.py",
        "chance / (TWO_PI * cone.one_minus_cos)",
        "chance / (2 * TWO_PI * cone.one_minus_cos)",
        "tests/emitters/test_sampling.py",
    ),
    Mutation(
        "a rectangle's solid angle with a wrong sign",
        "emitters/rectangle.py",
        "    omega -= left\n",
        "    omega += left\n",
        "tests/emitters/test_sampling.py",
    ),
    Mutation(
        "suns that forget the chance of being chosen",
        "emitters/sun.py",
        "[r * a / c for r, a, c in zip(radiance, cone, chance, strict=True)]",
        "[r * a for r, a, c in zip(radiance, cone, chance, strict=True)]",
        "tests/emitters/test_mixture.py",
    ),
    Mutation(
        "a sky whose rows are all as large as each other",
        "emitters/environment.py",
        "edges = -np.cos(np.pi * np.arange(height + 1) / height)",
        "edges = 2.0 * np.arange(height + 1) / height - 1.0",
        "tests/emitters/test_sampling.py",
    ),
    Mutation(
        "the concentric map with too wide an angle",
        "core/warps.py",
        "angle = (0.25 * PI) * other",
        "angle = (0.26 * PI) * other",
        "tests/core/test_warps.py",
    ),
    Mutation(
        "triangles without the root",
        "core/warps.py",
        "    s = np.sqrt(u)\n    return np.stack([1.0 - s, v * s])",
        "    s = u * 1.0\n    return np.stack([1.0 - s, v * s])",
        "tests/core/test_warps.py",
    ),
    Mutation(
        "alias tables read the wrong way round",
        "core/distributions.py",
        "other = rest >= keep\n    index",
        "other = rest < keep\n    index",
        "tests/core/test_distributions.py",
    ),
    Mutation(
        "all dimensions with one key",
        "core/samplers.py",
        "hash_words(self.seed, 2, first + k)",
        "hash_words(self.seed, 2, 0)",
        "tests/core/test_hashing.py",
    ),
    Mutation(
        "normals that turn as points do",
        "scene/transforms.py",
        "return _apply(_of(self._normal, instance), n)",
        "return _apply(_of(self._linear, instance), n)",
        "tests/scene/test_transforms.py",
    ),
    Mutation(
        "closures' densities added without their shares",
        "scene/shading.py",
        "pdf += share * p",
        "pdf += p",
        "tests/scene/test_shading.py",
    ),
    Mutation(
        "a lens that focuses twice as far",
        "cameras/perspective.py",
        "d = toward * np.float32(self._focus)",
        "d = toward * np.float32(2 * self._focus)",
        "tests/cameras/test_cameras.py",
    ),
)
