"""Blender's evaluated scene becomes a snapshot."""
