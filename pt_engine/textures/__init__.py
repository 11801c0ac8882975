"""Image lookups."""
