"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from . import _process as _process  # isort: skip  (before all that takes long to load)

from . import _carried as _carried  # isort: skip  (before the module whose lack it explains)

from . import exporting as exporting
from . import guided as guided
from . import guides as guides
from . import within as within
from ._core import (
    Cancelled,
    CleanOptions,
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
    all_statistics,
    backends,
    clean,
    delete_least,
    delete_proxy,
    erase_faces,
    even_borders,
    expected_polygons,
    grow_region,
    improve,
    lock_regions,
    merge_cheapest,
    merge_regions,
    opening_length,
    opening_lengths,
    paint_faces,
    partition,
    partition_from,
    polygonize,
    region_statistics,
    regularise,
    separated_faces,
    shrink_region,
    split_along,
    split_region,
    triangulate,
    unlock_regions,
)
from .exporting import write
from .reading import read, read_polygons
from .texturing import Texture, TexturedSoup, read_textured, texture, write_textured

__all__ = [
    "Cancelled",
    "CleanOptions",
    "FileError",
    "InvalidInput",
    "Job",
    "Mesh",
    "MeshingOptions",
    "Partition",
    "PartitionOptions",
    "PolygonMesh",
    "RegulariseOptions",
    "Texture",
    "TextureOptions",
    "TexturedSoup",
    "__version__",
    "add_proxy",
    "add_worst",
    "all_statistics",
    "backends",
    "clean",
    "delete_least",
    "delete_proxy",
    "erase_faces",
    "even_borders",
    "expected_polygons",
    "grow_region",
    "improve",
    "lock_regions",
    "merge_cheapest",
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
    "region_statistics",
    "regularise",
    "separated_faces",
    "shrink_region",
    "split_along",
    "split_region",
    "texture",
    "triangulate",
    "unlock_regions",
    "write",
    "write_textured",
]

for _name in __all__:
    if isinstance(_thing := globals()[_name], type) and _thing.__module__.endswith("._core"):
        _thing.__module__ = __name__  # so that messages and pickles name the package, not its compiled part
