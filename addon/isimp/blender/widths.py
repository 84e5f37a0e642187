"""Measures the sidebar in letters. Imports neither numpy nor the engine."""


def letters(context) -> int:
    """Return how many letters fit into a line after an icon."""
    width = context.region.width / context.preferences.system.ui_scale if context.region else 260
    return max(8, int((width - 66) / 6.1))
