"""The settings of Partition and Mesh as Blender's properties, for operators and the panel; see settings.py."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .. import recipe as rcp
from ..engine_options import MESHING, PARTITION, REGULARISE
from ..option import Option
from . import targets, weights

_PARTITION, _MESH, _REGULARISE = rcp.Partition(), rcp.Mesh(), rcp.Regularise()


def _weights(self, context, edit_text):
    """The suggestions of the field for weights."""
    scan, problem = targets.find(context)
    return [] if problem else weights.names(scan)


def _face_attributes(self, context, edit_text):
    """The suggestions of the field for the attribute of barriers."""
    scan, problem = targets.find(context)
    return [] if problem else weights.face_names(scan)


_CAN_SEARCH = "search" in StringProperty.__doc__
_SEARCHED = {"search": _weights} if _CAN_SEARCH else {}
_FACES_SEARCHED = {"search": _face_attributes} if _CAN_SEARCH else {}


def _range(option: Option) -> dict:
    """The ends of the range of an engine's option, as far as they are in it."""
    number = int if option.kind == "int" else float
    least = {} if option.least is None or option.above_least else {"min": number(option.least)}
    most = {} if option.most is None or option.below_most else {"max": number(option.most)}
    return least | most


class PartitionSettings:
    count_by: EnumProperty(
        name="Count By",
        description="How the number of regions is chosen",
        items=(
            ("detail", "Automatic", "The number follows from the shape, at a detail that is a share of its size"),
            ("proxies", "Count", "An exact number"),
            (
                "tolerance",
                "Tolerance",
                "The number follows from a length: smaller shapes are ignored, below .2 m on a building, say",
            ),
            ("bound", "Bound", "The number follows from the largest distance of a vertex from its region's plane"),
            ("triangles", "Triangles", "As many regions as the polygons can have that make this number of triangles"),
        ),
        default=_PARTITION.count_by,
    )
    detail: FloatProperty(
        name="Detail",
        description="Shapes below this share of the scan's size are ignored. A smaller value gives more regions",
        default=_PARTITION.detail,
        min=0.0001,
        max=1.0,
        soft_max=0.05,
        precision=4,
        step=0.05,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Shapes below this length are ignored. A smaller value gives more regions",
        default=_PARTITION.tolerance,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    bound: FloatProperty(
        name="Bound",
        description="Largest distance of a vertex from its region's plane. A smaller value gives more regions",
        default=_PARTITION.bound,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    adaptivity: FloatProperty(
        name="Finer Where Rough",
        description="Smaller regions where the scan is rough. 0: the same detail everywhere",
        default=_PARTITION.adaptivity,
        **_range(PARTITION["adaptivity"]),
    )
    smooth: FloatProperty(
        name="Straight Borders",
        description="How much short, straight borders count beside the error. 0: least error. 1: cleanest shapes",
        default=_PARTITION.smooth,
        **_range(PARTITION["smooth"]),
    )
    symmetry: EnumProperty(
        name="Symmetry",
        description="Regions and corners mirror, as the scan does within its noise",
        items=(
            ("none", "None", "Regions do not mirror"),
            ("x", "X", "Mirror in a plane across the scan's X axis, or nearly so"),
            ("y", "Y", "Mirror in a plane across the scan's Y axis, or nearly so"),
            ("z", "Z", "Mirror in a plane across the scan's Z axis, or nearly so"),
            ("found", "Found", "Mirror in the plane in which the scan mirrors, if there is one"),
        ),
        default=_PARTITION.symmetry,
    )
    curved: BoolProperty(
        name="Round Parts",
        description="Cylinders, cones, spheres, surfaces of revolution and extrusions become regular segments",
        default=_PARTITION.curved,
    )
    close_openings: BoolProperty(
        name="Close Openings",
        description="Close holes and tunnels of a noisy scan that the regions can't show",
        default=_PARTITION.close_openings,
    )
    noise: FloatProperty(
        name="Noise",
        description="Standard deviation of the scan's points, in the scan's units. Below 0: estimated",
        default=_PARTITION.noise,
        min=-1.0,
        soft_max=0.1,
        precision=5,
    )
    snap: BoolProperty(
        name="Snap to Planes",
        description="If the shape clearly consists of planes, make one region for each plane",
        default=_PARTITION.snap,
    )
    proxies: IntProperty(
        name="Regions",
        description="Number of regions. Each becomes one polygon, or a few",
        default=_PARTITION.proxies,
        soft_max=5000,
        **_range(PARTITION["proxies"]),
    )
    triangles: IntProperty(
        name="Triangles",
        description="The polygons of Mesh make at most this many triangles, as a game counts them",
        default=_PARTITION.triangles,
        soft_max=100000,
        **_range(PARTITION["triangles"]),
    )
    sharp_edges: FloatProperty(
        name="Edge Width",
        description="Regions at edges that are narrower than this go to the planes beside them, in the scan's units. "
        "0: three mean edges. Below 0: such regions stay",
        default=_PARTITION.sharp_edges,
        min=-1.0,
        soft_max=0.1,
        precision=5,
    )
    stitch: FloatProperty(
        name="Stitch",
        description="Largest gap between borders of chunks of a scan that become one, in the scan's units. 0: none do. "
        "Below 0: two mean edges, where a tenth of the border has another border that near",
        default=_PARTITION.stitch,
        min=-1.0,
        soft_max=1.0,
        precision=5,
    )
    grid: FloatProperty(
        name="Grid Cell",
        description="Cell of the grid of occupied cells that the mesh was cut on, whose steps are smoothed, in the "
        "scan's units. 0: steps stay. Below 0: it is found",
        default=_PARTITION.grid,
        min=-1.0,
        soft_max=1.0,
        precision=5,
    )
    method: EnumProperty(
        name="Method",
        description="Algorithm of the partition",
        items=(
            (
                "hierarchy",
                "Hierarchy",
                "Merge small patches, then relax the borders: the fastest, with the least error",
            ),
            (
                "teleport",
                "Teleport",
                "As Lloyd; then merge the cheapest pair and split the worst region while the error falls",
            ),
            ("lloyd", "Lloyd", "Flood from the seeds and fit planes, alternately: the method of the first paper"),
            ("queued", "Queued", "As Lloyd, but flood all faces of a queue at once: for GPUs"),
            ("naive", "Naive", "As Lloyd, but every face chooses among the nearest regions: for GPUs"),
            ("hybrid", "Hybrid", "Partition a decimated copy, and carry the regions back to the scan"),
        ),
        default=_PARTITION.method,
    )
    seeding: EnumProperty(
        name="Start",
        description="Faces at which the first regions start (all methods except Hierarchy)",
        items=(
            ("random", "Random", "Random faces"),
            ("farthest", "Farthest", "Each face where the surface differs most from all regions so far"),
            ("hierarchical", "Hierarchical", "One face in each region of the method Hierarchy"),
        ),
        default=_PARTITION.seeding,
    )
    seed: IntProperty(
        name="Seed",
        description="Seed of the random numbers",
        default=_PARTITION.seed,
        **_range(PARTITION["seed"]),
    )
    iterations: IntProperty(
        name="Iterations",
        description="Maximum number of rounds of flooding and fitting. Fewer if the regions stop changing",
        default=_PARTITION.iterations,
        soft_max=100,
        **_range(PARTITION["iterations"]),
    )
    leave_out: FloatProperty(
        name="Ignore Parts Below",
        description="Loose parts below this share of the total area get no region and no polygon. 0: keep every part",
        default=_PARTITION.leave_out,
        max=0.99,
        precision=4,
        step=0.01,
        **_range(PARTITION["leave_out"]),
    )

    weights: StringProperty(
        name="Weights",
        description="A vertex group (from weight paint) or an attribute of faces or vertices. Higher weights give more "
        "and smaller regions; with Count, the total number stays. Empty: no weights",
        default=_PARTITION.weights,
        **_SEARCHED,
    )
    influence: FloatProperty(
        name="Influence",
        description="Strength of the weights. At 1, a weight of 1 gives four times as many regions as a weight of 0",
        default=_PARTITION.influence,
        min=0.0,
        max=2.0,
    )

    seams: BoolProperty(
        name="Seams",
        description="No region crosses an edge that is marked as a seam (Edge > Mark Seam)",
        default=_PARTITION.seams,
    )
    sharp: BoolProperty(
        name="Sharp Edges",
        description="No region crosses an edge that is marked as sharp (Edge > Mark Sharp)",
        default=_PARTITION.sharp,
    )
    materials: BoolProperty(
        name="Materials", description="No region has faces of two materials", default=_PARTITION.materials
    )
    face_sets: BoolProperty(
        name="Face Sets",
        description="No region has faces of two face sets (of Sculpt Mode)",
        default=_PARTITION.face_sets,
    )
    angle: FloatProperty(
        name="Angle",
        description="No region crosses an edge with a larger angle between its faces, in degrees. 180: no limit",
        default=_PARTITION.angle,
        min=0.0,
        max=180.0,
        precision=0,
        step=100,
    )
    borders: StringProperty(
        name="Attribute",
        description="No region has faces with different values of this face attribute. Empty: no such barrier",
        default=_PARTITION.borders,
        **_FACES_SEARCHED,
    )


class MeshSettings:
    straight_rims: FloatProperty(
        name="Straight Rims",
        description="How far straight rims may leave the ragged border of an open scan, in the scan's units. 0: rims "
        "follow the border. Below 0: twice the raggedness, where the border is ragged",
        default=_MESH.straight_rims,
        min=-1.0,
        soft_max=1.0,
        precision=5,
    )
    chord_tolerance: FloatProperty(
        name="Corner Tolerance",
        description="Distance of a border from a straight line at which it gets another corner, as a share of a "
        "region's size. A smaller value follows the scan more closely, with more corners",
        default=_MESH.chord_tolerance,
        min=0.01,
        soft_max=2.0,
    )
    join_junctions: FloatProperty(
        name="Join Junctions",
        description="Largest distance at which two vertices of three polygons become one vertex of four, as a share "
        "of a region's size, where that gives better polygons. 0: none",
        default=_MESH.join_junctions,
        soft_max=2.0,
        **_range(MESHING["join_junctions"]),
    )
    flatten: IntProperty(
        name="Flatten",
        description="Rounds of moving corners to make polygons planar. 0: corners keep their first positions",
        default=_MESH.flatten,
        soft_max=200,
        **_range(MESHING["flatten"]),
    )
    planar: BoolProperty(
        name="Exactly Flat Faces",
        description="Make every polygon exactly planar. Corners that can't be on the plane of their polygon are cut "
        "off as triangles",
        default=_MESH.planar,
    )
    planar_most: FloatProperty(
        name="Cut at Most",
        description="Largest share of the polygons that Exactly Flat Faces may cut. If more would be, polygons stay "
        "whole and are not exactly planar, and the report says so",
        default=_MESH.planar_most,
        subtype="FACTOR",
        **_range(MESHING["planar_most"]),
    )


def _length(description: str, name: str = "Allowed"):
    return FloatProperty(
        name=name,
        description=description,
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )


class RegulariseSettings:
    angle: FloatProperty(
        name="Angle",
        description="Largest angle by which a plane is turned, in degrees",
        default=_REGULARISE.angle,
        **_range(REGULARISE["angle"]),
    )
    length: _length(
        "What snapping may add to the distance of a region from its plane. 0: it follows from the noise of the scan, "
        "and all planes together add a tenth at most"
    )
    up: EnumProperty(
        name="Up",
        description="What level and upright mean",
        items=(
            ("scene", "Scene", "The Z axis of the scene, however the scan is turned"),
            ("x", "Scan X", "The X axis of the scan"),
            ("y", "Scan Y", "The Y axis of the scan"),
            ("z", "Scan Z", "The Z axis of the scan"),
            ("region", "Region", "The region of the selected face is level"),
            ("none", "None", "No plane is level or upright, only parallel to others"),
        ),
        default=_REGULARISE.up,
    )
    even_spacing: BoolProperty(
        name="Even Spacing",
        description="Make distances of parallel planes equal: of storeys, steps and rows of windows, and the widths "
        "that three or more windows have in common",
        default=_REGULARISE.even_spacing,
    )
    merge_islands: _length(
        "Window panes that are coplanar with the wall round them become part of it, with rims up to this depth. "
        "0: none do",
        "Merge Islands",
    )


class AlignSettings:
    to: EnumProperty(
        name="To",
        description="What the planes of the regions become",
        items=(
            ("level", "Level", "Level planes: floors, ceilings, flat roofs"),
            ("upright", "Upright", "Upright planes: walls"),
            ("parallel", "Parallel", "Parallel to the plane of the region that leads"),
            ("perpendicular", "Perpendicular", "At right angles to the plane of the region that leads"),
            ("coplanar", "Coplanar", "One plane for all"),
            ("free", "Free", "As scanned: no longer held, also not by Regularise"),
        ),
    )
    length: _length("How far a plane may go off its region when it is set by hand. 0: one percent of the scan's size")
