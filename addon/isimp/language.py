"""The language of the add-on's messages, which recipes share."""

from .recipe import count, noun, own, plural, said, speak

__all__ = ["count", "noun", "own", "plural", "said", "speak"]
