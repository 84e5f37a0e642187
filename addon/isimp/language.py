"""Re-exports the functions that translate messages, which recipes use too."""

from .recipe import count, noun, own, plural, said, speak

__all__ = ["count", "noun", "own", "plural", "said", "speak"]
