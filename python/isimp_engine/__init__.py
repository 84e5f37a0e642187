"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from . import _process as _process  # isort: skip  (before all that takes long to load)

from typing import TYPE_CHECKING  # isort: skip

from . import _carried as _carried  # isort: skip  (before the module whose lack it explains)

from . import clutter as clutter
from . import exporting as exporting
from . import guided as guided
from . import guides as guides
from . import openings as openings
from . import parts as parts
from . import regions as regions
from . import replay as replay
from . import sizes as sizes
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
    backends,
    clean,
    delete_least,
    delete_proxy,
    erase_faces,
    even_borders,
    grow_region,
    improve,
    leave_out_regions,
    lock_regions,
    make_round,
    merge_cheapest,
    merge_flat,
    merge_regions,
    paint_faces,
    partition,
    partition_from,
    polygonize,
    regularise,
    release_round,
    set_segments,
    shrink_region,
    split_along,
    split_region,
    unlock_regions,
)
from ._old_names import by_old_name
from .convex import convex_parts
from .exporting import write
from .reading import read
from .recipe import RecipeError
from .result import Result, simplify
from .texturing import (
    Texture,
    TexturedSoup,
    TextureLayer,
    read_textured,
    texture,
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
    "RecipeError",
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
    "backends",
    "clean",
    "convex_parts",
    "delete_least",
    "delete_proxy",
    "erase_faces",
    "even_borders",
    "grow_region",
    "improve",
    "leave_out_regions",
    "lock_regions",
    "make_round",
    "merge_cheapest",
    "merge_flat",
    "merge_regions",
    "paint_faces",
    "partition",
    "partition_from",
    "polygonize",
    "read",
    "read_textured",
    "regularise",
    "release_round",
    "set_segments",
    "shrink_region",
    "simplify",
    "split_along",
    "split_region",
    "texture",
    "unlock_regions",
    "write",
    "write_textured",
]

if not TYPE_CHECKING:  # else every name would be one for type checkers
    _OLD = {name: f"regions.{name}" for name in regions.__all__}
    _OLD |= {name: f"texturing.{name}" for name in ("corner_sources", "uv_islands")}
    _OLD |= {
        "explode_round": "release_round",
        "with_segments": "set_segments",
        "read_polygons": "reading.read_polygons",
    }
    _OLD |= {"patch_of": "regions.round_part_at", "separated_faces": "regions.barrier_faces"}
    __getattr__ = by_old_name(__name__, _OLD)

for _name in __all__:
    if isinstance(_thing := globals()[_name], type) and _thing.__module__.endswith("._core"):
        _thing.__module__ = __name__  # so that messages and pickles name the package, not its compiled part
