"""Integrators, passes, film and statistics."""
