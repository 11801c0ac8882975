"""`python -m pt_engine`: the command line lives in blender/cli, because it drives Blender."""

from .blender.cli import run

run()
