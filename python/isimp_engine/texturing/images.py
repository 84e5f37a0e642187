"""Image files, by way of Pillow."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, InvalidInput
from . import udim

Image = NDArray[Any]  # (H, W, 4) uint8 or uint16, row 0 at the top


def pillow(name: object) -> Any:
    """Pillow's module of images; it is loaded only where an image file is read or written."""
    try:
        import PIL.Image
    except ImportError:
        raise FileError(f"{name}: reading and writing images needs Pillow; install it: pip install pillow") from None
    return PIL.Image


def load(path: Path, named_by: str) -> Image | dict[int, Image]:
    """The image of a file, or those of UDIM tiles by their numbers. `named_by` says where the name stands."""
    if udim.is_pattern(path):
        files = udim.files(path)
        if not files:
            raise FileError(f"{named_by}: no file has the name {path} with the number of a tile; put them there")
        return {tile: decode(file, str(file)) for tile, file in files.items()}
    if not path.is_file():
        raise FileError(f"{named_by}: the image {path} does not exist; put it there, or correct the name")
    return decode(path, str(path))


def decode(source: Path | bytes, name: str) -> Image:
    """The image of a file or of the bytes of one."""
    module = pillow(name)
    try:
        with module.open(io.BytesIO(source) if isinstance(source, bytes) else source) as image:
            return _pixels(image)
    except (OSError, ValueError, SyntaxError, module.DecompressionBombError) as error:
        raise FileError(f"{name}: is not an image that can be read: {error}") from None


def _pixels(image: Any) -> Image:
    """8 or 16 bits as the image has them; palettes, grey and other spaces as RGBA."""
    if image.mode.startswith("I"):  # 16 bits of grey
        return rgba(np.clip(np.asarray(image), 0, 0xFFFF).astype(np.uint16))
    if image.mode == "F":
        return rgba(np.asarray(image))
    return np.ascontiguousarray(image.convert("RGBA"))


def rgba(pixels: Any, name: str = "image") -> Image:
    """Grey, grey with alpha, RGB or RGBA of any usual kind of number as (H, W, 4) uint8 or uint16.

    Numbers with a fraction are from 0 to 1. Grey has no channel axis, or one or two channels.
    """
    array = np.asarray(pixels)
    if array.ndim == 2:
        array = array[:, :, None]
    if array.ndim != 3 or not 1 <= array.shape[2] <= 4 or 0 in array.shape:
        raise InvalidInput(f"{name} must have the shape (H, W) or (H, W, 1 to 4), got {np.shape(pixels)}")
    if array.dtype == np.bool_:
        array = array.astype(np.uint8) * 255
    elif np.issubdtype(array.dtype, np.floating):
        array = np.round(np.clip(np.nan_to_num(array), 0, 1) * 0xFFFF).astype(np.uint16)
    elif array.dtype not in (np.uint8, np.uint16):
        raise InvalidInput(f"{name} must hold uint8, uint16 or floating-point numbers, got {array.dtype}")
    channels = array.shape[2]
    full = np.full(array.shape[:2] + (4,), np.iinfo(array.dtype).max, dtype=array.dtype)
    full[:, :, :3] = array[:, :, :3] if channels >= 3 else array[:, :, :1]
    if channels in (2, 4):
        full[:, :, 3] = array[:, :, -1]
    return full


def png(pixels: NDArray[Any], name: object) -> bytes:
    """An image as a PNG file, 8 bits or grey of 16; without an alpha channel where it says nothing."""
    if pixels.ndim == 3 and pixels.shape[2] == 4 and (pixels[:, :, 3] == 255).all():
        pixels = pixels[:, :, :3]
    out = io.BytesIO()
    pillow(name).fromarray(np.ascontiguousarray(pixels)).save(out, format="PNG", compress_level=6)
    return out.getvalue()
