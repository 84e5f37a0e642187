"""Parts with planar faces under the noise of a scan."""

import numpy as np
import pytest

import isimp_engine as engine

pytest.importorskip("OCP")
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakePrism
from OCP.gp import gp_Pnt, gp_Vec

from bench.generators.known_shapes import rotation
from bench.quality import mfcad

NOISE = 0.002


def notched():
    """A block with a slot, and a wedge from the other side that cuts a small notch into the floor of the slot."""
    block = BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), gp_Pnt(10, 8, 10)).Shape()
    slot = BRepPrimAPI_MakeBox(gp_Pnt(4, -1, -1), gp_Pnt(6, 3.565, 11)).Shape()
    outline = BRepBuilderAPI_MakePolygon(gp_Pnt(-1, 3.25, 5), gp_Pnt(-1, 8.1, 8.6), gp_Pnt(-1, 8.1, 3), True).Wire()
    wedge = BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline).Face(), gp_Vec(12, 0, 0)).Shape()
    return BRepAlgoAPI_Cut(BRepAlgoAPI_Cut(block, slot).Shape(), wedge).Shape()


@pytest.mark.parametrize("seed", [1, 3])
def test_near_junctions_that_noise_does_not_explain_stay_apart(seed):
    corners, face = mfcad.triangles_of(notched())
    corners = corners @ rotation(np.random.default_rng(seed)).T
    noise = NOISE * mfcad.size_of(corners)
    *scan, label = mfcad.scan_of(corners, face, noise, seed)
    row = mfcad.row_of(engine.simplify(tuple(scan)), corners, face, label, noise)
    assert row["regions"] == row["planes"] == 14
    assert row["degrees"] < 1
    assert np.all(row["close"])
