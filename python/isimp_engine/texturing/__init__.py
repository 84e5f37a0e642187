"""The texture of a scan, read, put on its polygons and written."""

from .baking import Texture, texture
from .layers import TextureLayer
from .places import corner_sources, uv_islands
from .reading import read_textured
from .soup import TexturedSoup
from .writing import write_textured

__all__ = [
    "Texture",
    "TextureLayer",
    "TexturedSoup",
    "corner_sources",
    "read_textured",
    "texture",
    "uv_islands",
    "write_textured",
]
