"""Importing this fills the registry with the lecture's ladder, in its order."""

from . import normals, direct, path_fixed, path  # noqa: F401, I001
