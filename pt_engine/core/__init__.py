"""Vectors, warps, distributions, random numbers."""
