"""STEP: a boundary representation with true cylinders, cones, spheres and surfaces of revolution. Needs OpenCASCADE."""
