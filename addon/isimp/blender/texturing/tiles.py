"""Reads and makes images with UDIM tiles by files, since Blender has access to the pixels of the first tile only."""

import tempfile
from pathlib import Path

import bpy

from ...language import said
from ..scene import mesh_io


def read(image, pixels) -> dict:
    """Return the result of `pixels` for each tile of an image, by tile number. Raises Unusable."""
    if image.is_dirty:
        raise mesh_io.Unusable(
            said("The image '{name}' has tiles that are not saved: save or pack it first.", name=image.name)
        )
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for tile in image.tiles:
            path = _file_of(image, tile.number, Path(folder))
            if not path.is_file():
                facts = {"tile": tile.number, "name": image.name, "file": path}
                raise mesh_io.Unusable(said("The tile {tile} of the image '{name}' can't be read ({file}).", **facts))
            single = bpy.data.images.load(str(path))
            try:
                single.colorspace_settings.name = image.colorspace_settings.name
                found[tile.number] = pixels(single)
            finally:
                bpy.data.images.remove(single)
    return found


def _file_of(image, number: int, folder: Path):
    """Return the file of a tile; a packed tile is written to the folder."""
    for packed in image.packed_files:
        if packed.tile_number == number:
            path = folder / f"{number}{Path(packed.filepath).suffix}"
            path.write_bytes(packed.packed_file.data)
            return path
    name = bpy.path.abspath(image.filepath, library=image.library)
    column, row = (number - 1001) % 10, (number - 1001) // 10
    return Path(name.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}"))


def make(name: str, tiles: dict, single):
    """Return a packed image of tiles. tiles: arrays by tile number; `single(name, array)` makes an image of one."""
    with tempfile.TemporaryDirectory() as folder:
        for number, stored in tiles.items():
            one = single(name, stored)
            one.filepath_raw = str(Path(folder) / f"tile.{number}.png")
            one.file_format = "PNG"
            space = one.colorspace_settings.name
            one.save()
            bpy.data.images.remove(one)
        image = bpy.data.images.load(str(Path(folder) / f"tile.{min(tiles)}.png"))
        image.name, image.source = name, "TILED"
        image.filepath_raw = str(Path(folder) / "tile.<UDIM>.png")
        image.colorspace_settings.name = space
        there = {tile.number for tile in image.tiles}
        for number in sorted(tiles.keys() - there):
            image.tiles.new(number)
        image.pack()
    return image
