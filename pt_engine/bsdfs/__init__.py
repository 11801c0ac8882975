"""Scattering models, one a file."""
