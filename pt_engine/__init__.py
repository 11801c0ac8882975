"""pt_engine: a path tracer for Blender that people can read, trust and extend."""

__version__ = "0.1.0"
