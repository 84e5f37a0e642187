"""Measurements of the engine, by rooms; README.md lists them."""
