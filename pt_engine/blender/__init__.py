"""Everything that knows Blender: the engine, its panels, the export."""
