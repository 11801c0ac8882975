"""The prepared scene: acceleration, geometry, materials, lights."""
