"""Formulas broken on purpose, one at a time in a copy of the tree: the tests have to notice each.

`scripts/mutate` runs them all and prints a table; names as arguments pick some.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("pt_engine", "tests", "examples", "scenes", "pyproject.toml")


class Mutation(NamedTuple):
    """A change of one place of one file below pt_engine/, and the tests that are to fail then."""

    name: str
    file: str
    right: str
    wrong: str
    tests: str


MUTATIONS = (
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
        "np.reciprocal(1 + ratio * ratio)",
        "np.reciprocal(1 + ratio)",
        "tests/render/test_replay_text.py",
    ),
    Mutation(
        "roulette that does not divide by its chance",
        "render/survivors.py",
        "path.beta *= survives / q",
        "path.beta *= survives",
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
        "render/path_state.py",
        "side = np.copysign(si.bound, vectors.dot(si.ng, wo))",
        "side = si.bound",
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
        "np.uint32(hash_words(self.seed, 2, dimension))",
        "np.uint32(hash_words(self.seed, 2, 0))",
        "tests/core/test_hashing.py",
    ),
    Mutation(
        "normals that turn as points do",
        "scene/transforms.py",
        "return _apply(self._normal.take(instance, axis=0), n)",
        "return _apply(self._linear.take(instance, axis=0), n)",
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


def caught(mutation: Mutation, tree: Path) -> bool:
    """Whether the mutation's tests fail on a tree that has it. The tree is as before afterwards."""
    path = tree / "pt_engine" / mutation.file
    sound = path.read_text(encoding="utf-8")
    if sound.count(mutation.right) != 1:
        raise ValueError(f"{mutation.file} no longer has one {mutation.right!r}")
    path.write_text(sound.replace(mutation.right, mutation.wrong), encoding="utf-8")
    try:
        return tested(mutation.tests, tree) == 1
    finally:
        path.write_text(sound, encoding="utf-8")


def tested(tests: str, tree: Path) -> int:
    """pytest's exit code: 0 all passed, 1 some failed, else it could not even run."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow"]
    quiet = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [*command, *tests.split()], cwd=tree, env=quiet, capture_output=True, check=False
    ).returncode


def main(names: list[str]) -> int:
    """Try all mutations, or those whose names hold one of `names`; how many went unnoticed."""
    chosen = [m for m in MUTATIONS if not names or any(name in m.name for name in names)]
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, tree / name)
        for mutation in chosen:
            started = time.perf_counter()
            noticed = caught(mutation, tree)
            missed += not noticed
            verdict = "caught" if noticed else "MISSED"
            print(
                f"{verdict}  {mutation.name}  ({mutation.file}, {time.perf_counter() - started:.1f} s)",
                flush=True,
            )
    print(f"{len(chosen) - missed} of {len(chosen)} caught")
    return missed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
