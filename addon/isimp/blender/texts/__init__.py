"""Texts about numbers of a result."""
