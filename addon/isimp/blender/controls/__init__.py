"""Settings as Blender's properties."""
