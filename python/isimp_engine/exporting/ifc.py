"""IFC4: walls, a roof and slabs as IfcPolygonalFaceSet. Needs the package ifcopenshell."""

from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from .._core import PolygonMesh
from .surfaces import CEILING, CLASSES, GROUND, ROOF, WALL, Surfaces, part_of, rings

_ELEMENTS = {WALL: "IfcWall", ROOF: "IfcRoof", GROUND: "IfcSlab", CEILING: "IfcSlab"}
_TYPES = {GROUND: "BASESLAB", CEILING: "FLOOR"}
_FAR = 1e4  # coordinates beyond this are written relative to a place near the model


def write(path: Path, poly: PolygonMesh, surfaces: Surfaces, name: str, crs: int | None = None) -> None:
    """Write n-gons without triangulation. The shift is a map conversion with a reference system, else a placement."""
    import ifcopenshell
    import ifcopenshell.guid

    file: Any = ifcopenshell.file(schema="IFC4")
    at = np.asarray(poly.vertices, dtype=np.float64)
    far = len(at) > 0 and float(np.abs(at).max()) > _FAR
    shift = np.floor(at.min(0)) if far or (crs is not None and len(at)) else np.zeros(3)
    placed = [0.0, 0.0, 0.0] if crs is not None else shift.tolist()

    def make(kind: str, **values: Any) -> Any:
        if kind in ("IfcProject", "IfcSite", "IfcBuilding") or kind.startswith("IfcRel") or kind in _ELEMENTS.values():
            values["GlobalId"] = ifcopenshell.guid.new()
        return file.create_entity(kind, **values)

    def placement(parent: Any, place: list[float]) -> Any:
        axes = make("IfcAxis2Placement3D", Location=make("IfcCartesianPoint", Coordinates=place))
        return make("IfcLocalPlacement", PlacementRelTo=parent, RelativePlacement=axes)

    world = make("IfcAxis2Placement3D", Location=make("IfcCartesianPoint", Coordinates=[0.0, 0.0, 0.0]))
    context = make(
        "IfcGeometricRepresentationContext",
        ContextType="Model",
        CoordinateSpaceDimension=3,
        Precision=1e-6,
        WorldCoordinateSystem=world,
    )
    if crs is not None:
        system = make("IfcProjectedCRS", Name=f"EPSG:{crs}")
        east, north, height = shift.tolist()
        make(
            "IfcMapConversion",
            SourceCRS=context,
            TargetCRS=system,
            Eastings=east,
            Northings=north,
            OrthogonalHeight=height,
        )
    units = make("IfcUnitAssignment", Units=[make("IfcSIUnit", UnitType="LENGTHUNIT", Name="METRE")])
    project = make("IfcProject", Name=name, RepresentationContexts=[context], UnitsInContext=units)
    site = make("IfcSite", Name=name, ObjectPlacement=placement(None, placed))
    building = make("IfcBuilding", Name=name, ObjectPlacement=placement(site.ObjectPlacement, [0.0, 0.0, 0.0]))
    make("IfcRelAggregates", RelatingObject=project, RelatedObjects=[site])
    make("IfcRelAggregates", RelatingObject=site, RelatedObjects=[building])
    loops, elements = rings(poly), []
    for kind in CLASSES:
        some = surfaces.of(kind)
        if not some:
            continue
        places, parts = part_of(poly, loops, some)
        points = make("IfcCartesianPointList3D", CoordList=(places - shift).tolist())
        faces = [make("IfcIndexedPolygonalFace", CoordIndex=(part + 1).tolist()) for part in parts]
        shape = make("IfcPolygonalFaceSet", Coordinates=points, Closed=False, Faces=faces)
        body = make(
            "IfcShapeRepresentation",
            ContextOfItems=context,
            RepresentationIdentifier="Body",
            RepresentationType="Tessellation",
            Items=[shape],
        )
        more = {"PredefinedType": _TYPES[kind]} if kind in _TYPES else {}
        elements.append(
            make(
                _ELEMENTS[kind],
                Name=kind,
                ObjectPlacement=placement(building.ObjectPlacement, [0.0, 0.0, 0.0]),
                Representation=make("IfcProductDefinitionShape", Representations=[body]),
                **more,
            )
        )
    if elements:
        make("IfcRelContainedInSpatialStructure", RelatingStructure=building, RelatedElements=elements)
    file.header.file_name.originating_system = f"isimp {_core.__version__}"
    path.write_text(file.to_string(), encoding="utf-8")  # the package's writer does not name the file in errors
