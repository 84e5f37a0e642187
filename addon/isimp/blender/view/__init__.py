"""Drawing and shading of the 3D view: overlay, comparison, colours, quick start."""
