"""The hard cases: a table of what breaks renderers, what is expected there, and what is measured here.

`python -m pt_engine selftest` runs the quick ones on any machine, without Blender; the tests run them all.
A file per subject; `case.py` says what a row is, `table.py` prints them.
"""
