"""Texts about the numbers of a result, for the panel and the viewport."""
