"""Drawing by the graphics card."""
