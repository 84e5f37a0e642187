"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from . import _process as _process  # isort: skip  (before all that takes long to load)

import warnings  # isort: skip
from typing import TYPE_CHECKING  # isort: skip

from . import _carried as _carried  # isort: skip  (before the module whose lack it explains)

from . import clutter as clutter
from . import exporting as exporting
from . import guided as guided
from . import guides as guides
from . import nearer as nearer
from . import openings as openings
from . import replay as replay
from . import within as within
from ._core import (
    Cancelled,
    CleanOptions,
    CurvedProxy,
    FileError,
    InvalidInput,
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    PolygonMesh,
    RegulariseOptions,
    TextureOptions,
    __version__,
    add_proxy,
    add_worst,
    align_planes,
    all_statistics,
    backends,
    barrier_faces,
    clean,
    close_openings,
    delete_least,
    delete_proxy,
    erase_faces,
    even_borders,
    expected_polygons,
    grow_region,
    improve,
    leave_out_regions,
    lock_regions,
    make_round,
    merge_cheapest,
    merge_flat,
    merge_regions,
    opening_length,
    opening_lengths,
    paint_faces,
    partition,
    partition_from,
    polygonize,
    region_fits,
    region_sides,
    region_statistics,
    regularise,
    release_round,
    round_part_at,
    set_segments,
    shrink_region,
    split_along,
    split_region,
    triangulate,
    unlock_regions,
)
from .exporting import write
from .reading import read, read_polygons
from .result import Result, simplify
from .texturing import (
    Texture,
    TexturedSoup,
    TextureLayer,
    corner_sources,
    read_textured,
    texture,
    uv_islands,
    write_textured,
)

__all__ = [
    "Cancelled",
    "CleanOptions",
    "CurvedProxy",
    "FileError",
    "InvalidInput",
    "Job",
    "Mesh",
    "MeshingOptions",
    "Partition",
    "PartitionOptions",
    "PolygonMesh",
    "RegulariseOptions",
    "Result",
    "Texture",
    "TextureLayer",
    "TextureOptions",
    "TexturedSoup",
    "__version__",
    "add_proxy",
    "add_worst",
    "align_planes",
    "all_statistics",
    "backends",
    "barrier_faces",
    "clean",
    "close_openings",
    "corner_sources",
    "delete_least",
    "delete_proxy",
    "erase_faces",
    "even_borders",
    "expected_polygons",
    "grow_region",
    "improve",
    "leave_out_regions",
    "lock_regions",
    "make_round",
    "merge_cheapest",
    "merge_flat",
    "merge_regions",
    "opening_length",
    "opening_lengths",
    "paint_faces",
    "partition",
    "partition_from",
    "polygonize",
    "read",
    "read_polygons",
    "read_textured",
    "region_fits",
    "region_sides",
    "region_statistics",
    "regularise",
    "release_round",
    "round_part_at",
    "set_segments",
    "shrink_region",
    "simplify",
    "split_along",
    "split_region",
    "texture",
    "triangulate",
    "unlock_regions",
    "uv_islands",
    "write",
    "write_textured",
]

if not TYPE_CHECKING:  # else every name would be one for type checkers
    _RENAMED = {
        "explode_round": "release_round",
        "patch_of": "round_part_at",
        "separated_faces": "barrier_faces",
        "with_segments": "set_segments",
    }

    def __getattr__(name: str) -> object:
        """The functions by their names of earlier versions."""
        if name not in _RENAMED:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        warnings.warn(f"{__name__}.{name} is now {_RENAMED[name]}", DeprecationWarning, stacklevel=2)
        return globals()[_RENAMED[name]]


for _name in __all__:
    if isinstance(_thing := globals()[_name], type) and _thing.__module__.endswith("._core"):
        _thing.__module__ = __name__  # so that messages and pickles name the package, not its compiled part
