"""Image files, by way of Pillow."""

import io
import logging
import os
import threading
import warnings
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from .. import machine
from .._core import FileError, InvalidInput
from ..file_errors import reader
from . import udim

Image = NDArray[Any]  # (H, W, 4) uint8 or uint16, row 0 at the top

#: Kinds to read, by content. Pillow knows more, such as PostScript, which it runs. TGA has no mark, so it comes last.
FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "WEBP", "GIF", "PPM", "JPEG2000", "DDS", "SGI", "PCX", "AVIF", "TGA")
_BLOCK = 1 << 22  # pixels that are worked on at once, so that intermediate values are small
_PILLOW = threading.Lock()  # its limit and the filters of warnings belong to the process


def pillow(name: object) -> Any:
    """Pillow's module of images; it is loaded only where an image file is read or written."""
    try:
        import PIL.Image
    except ModuleNotFoundError:
        raise FileError(f"{name}: reading and writing images needs Pillow; install it: pip install pillow") from None
    except ImportError as error:  # there is too little memory, for one
        raise FileError(f"{name}: reading and writing images needs Pillow, which can't be loaded ({error})") from None
    log = logging.getLogger("PIL")
    if not log.handlers:  # else Python writes its messages on damaged files to stderr
        log.addHandler(logging.NullHandler())
    return PIL.Image


class Pictures:
    """The images of one scan. Each file is decoded once, also under several names and for several materials."""

    def __init__(self) -> None:
        self._made: dict[Hashable, Image] = {}

    def load(self, path: Path, named_by: str) -> Image | dict[int, Image]:
        """The image of a file, or the images of UDIM tiles by their numbers. `named_by` is the place of the name."""
        if udim.is_pattern(path):
            files = udim.files(path)
            if not files:
                raise FileError(f"{named_by}: no file has the name {path} with the number of a tile; put them there")
            return {tile: self._file(file) for tile, file in files.items()}
        if not path.is_file():
            raise FileError(f"{named_by}: the image {path} does not exist; put it there, or correct the name")
        return self._file(path)

    def once(self, key: Hashable, make: Callable[[], Image]) -> Image:
        """The result of `make`, made once for each key."""
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def changed(self, image: Image, key: Hashable, change: Callable[[Image], Image]) -> Image:
        """An image made from these by a change, which `key` names."""
        return self.once((id(image), key), lambda: change(image))

    def _file(self, path: Path) -> Image:
        return self.once(os.path.realpath(path), lambda: decode(path, str(path)))


def decode(source: Path | bytes, name: str) -> Image:
    """The image of a file or of the bytes of one. Raises FileError."""
    module = pillow(name)
    with reader(name, "is not an image that can be read"), _PILLOW, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with io.BytesIO(source) if isinstance(source, bytes) else source.open("rb") as file:
            image = _opened(module, file)
            _check_room(image, name)
            try:
                return _pixels(image)
            except MemoryError:  # damaged ones end so too
                raise FileError(f"{name}: there is not enough memory for this image, or it is damaged") from None


def _opened(module: Any, file: IO[bytes]) -> Any:
    """The image of a file, without Pillow's limit on pixels; `_check_room` has another one."""
    limit, module.MAX_IMAGE_PIXELS = module.MAX_IMAGE_PIXELS, None
    try:
        return module.open(file, formats=FORMATS)
    except module.UnidentifiedImageError:
        raise ValueError(f"it is none of {', '.join(FORMATS)}") from None
    finally:
        module.MAX_IMAGE_PIXELS = limit


def _check_room(image: Any, name: str) -> None:
    """Refuse an image that memory has no room for, by its header; images that were read before have theirs."""
    width, height = image.size
    need = width * height * (4 + 4 * _numbers(image).itemsize) / 2**20  # Pillow's, and ours
    free = machine.memory_mb()
    if need > free:
        pixels = f"{width:,} x {height:,} pixels"
        raise FileError(f"{name}: has {pixels}, which take {need:,.0f} MB of memory, and {free:,.0f} MB are free")


def _numbers(image: Any) -> np.dtype[Any]:
    return np.dtype(np.uint16 if image.mode.startswith(("I", "F")) else np.uint8)


def _pixels(image: Any) -> Image:
    """8 or 16 bits as the image has them; palettes, grey and other spaces as RGBA."""
    image.load()
    width, height = image.size
    pixels = np.empty((height, width, 4), _numbers(image))
    rows = max(1, _BLOCK // max(width, 1))
    for top in range(0, height, rows):
        part = image.crop((0, top, width, min(top + rows, height)))
        if image.mode.startswith("I"):  # 16 bits of grey
            pixels[top : top + rows] = rgba(np.clip(np.asarray(part), 0, 0xFFFF).astype(np.uint16))
        elif image.mode == "F":
            pixels[top : top + rows] = rgba(np.asarray(part))
        else:
            pixels[top : top + rows] = np.asarray(part.convert("RGBA"))
    return settled(pixels)


def settled(pixels: Image) -> Image:
    """An image that is not changed any more, so that it need not be copied."""
    pixels.flags.writeable = False
    return pixels


def by_rows(image: Image, change: Callable[[Image], NDArray[np.float64]]) -> Image:
    """An image of numbers from 0 to 1 that `change` makes of some rows at a time."""
    made = np.empty(image.shape[:2] + (4,), np.uint16)
    rows = max(1, _BLOCK // max(image.shape[1], 1))
    for top in range(0, len(image), rows):
        made[top : top + rows] = rgba(change(image[top : top + rows]))
    return settled(made)


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
    if channels == 4 and array.flags.c_contiguous and not array.flags.writeable:
        return array
    full = np.full(array.shape[:2] + (4,), np.iinfo(array.dtype).max, dtype=array.dtype)
    full[:, :, :3] = array[:, :, :3] if channels >= 3 else array[:, :, :1]
    if channels in (2, 4):
        full[:, :, 3] = array[:, :, -1]
    return full


def png(pixels: NDArray[Any], name: object) -> bytes:
    """An image as a PNG file, 8 bits or grey of 16; without an alpha channel if all is opaque."""
    if pixels.ndim == 3 and pixels.shape[2] == 4 and (pixels[:, :, 3] == 255).all():
        pixels = pixels[:, :, :3]
    out = io.BytesIO()
    pillow(name).fromarray(np.ascontiguousarray(pixels)).save(out, format="PNG", compress_level=6)
    return out.getvalue()
