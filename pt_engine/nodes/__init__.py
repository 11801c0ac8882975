"""Shader graphs, compiled into programs over lanes."""
