"""The region that was clicked last: in Object Mode the buttons act on it, as a selection of faces is not seen there."""

from ..language import own
from . import mesh_io, runtime

NONE = own("No region is chosen: alt-click one with the Region tool (T), or select faces in Edit Mode (Tab, then 3)")


def note(scan, face: int) -> None:
    """A face of the scan was clicked; -1: the click was beside it."""
    runtime.get().pointed = (scan.name, face) if face >= 0 else None


def face(scan) -> int:
    """The face of a scan that was clicked last; -1 if there is none."""
    name, found = runtime.get().pointed or ("", -1)
    return found if name == scan.name and found < len(scan.data.polygons) else -1


def region(scan) -> int:
    """The region that it is in now; -1 if there is none. Cost: none to speak of."""
    found = face(scan)
    return mesh_io.region_of(scan, found) if found >= 0 else -1
