"""The add-on's messages: the words of the panel, right with one and with many."""

import re
from pathlib import Path

import numpy as np
import pytest

import shapes
from isimp import applying, messages
from isimp import recipe as rcp
from isimp.session import Session, StepFailed
from session_scans import scan_of


def failure(*steps):
    """The failure of the last of some steps on a bumpy sheet of 800 triangles."""
    with pytest.raises(StepFailed) as caught:
        Session().replay(scan_of(*shapes.bumpy(20)), rcp.Recipe(steps))
    assert caught.value.index == len(steps) - 1
    return caught.value


ROOT = Path(__file__).parents[3]
SPLIT = rcp.Partition(proxies=8)


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ((rcp.Partition(proxies=10**6),), "At most 800 regions are possible, one for each triangle"),
        (
            (SPLIT, rcp.LockRegions(faces=(5,)), rcp.AddProxy(face=5)),
            "This region is locked: press L over it, or Unlock",
        ),
        (
            (rcp.Partition(proxies=1), rcp.DeleteProxy(face=5)),
            "This is the only region of its loose part: it can't be deleted",
        ),
        ((SPLIT, rcp.MergeRegions(face=5, other=5)), "This is one region: there is nothing to merge"),
        (
            (rcp.Partition(proxies=800), rcp.SplitRegion(face=5)),
            "This region is a single face: there is nothing to split",
        ),
        ((SPLIT, rcp.PaintFaces(faces=(5,), onto=5)), "All these faces are in that region already, or locked"),
        (
            (SPLIT, rcp.CutRegion(face=5, line=((5, 5, 0), (6, 5, 0)), direction=(0, 0, 1))),
            "The line does not cross this region",
        ),
        ((SPLIT, rcp.AlignPlanes(faces=(5,), to="parallel")), "This is one region: select faces of two or more"),
        ((rcp.AddProxy(face=5),), "There are no regions yet: a Partition step must come first"),
        ((SPLIT, rcp.AddProxy(face=900)), "There is no face 900: the mesh has 800 faces"),
    ],
)
def test_a_failure_names_the_clicked_place(steps, said):
    error = failure(*steps)
    assert messages.failed(error, names_step=False) == said
    assert messages.failed(error, names_step=True).startswith(f"Step {len(steps)}, ")


def test_regions_far_apart_can_not_be_merged():
    scan, session = scan_of(*shapes.bumpy(20)), Session()
    label = session.replay(scan, rcp.Recipe((SPLIT,))).face_region
    pairs = {(a, b) for a, b in label[scan.face_edges[0]].tolist()}
    first, other = next((a, b) for a in range(8) for b in range(8) if a != b and not {(a, b), (b, a)} & pairs)
    faces = [int(np.flatnonzero(label == region)[0]) for region in (first, other)]
    error = failure(SPLIT, rcp.MergeRegions(face=faces[0], other=faces[1]))
    assert messages.failed(error, False) == "Only neighbouring regions can be merged"


@pytest.mark.parametrize(
    ("number", "said"), [(0, "0 regions"), (1, "1 region"), (2, "2 regions"), (1280, "1,280 regions")]
)
def test_counts(number, said):
    assert messages.count(number, "region") == said


def test_one_and_many():
    assert messages.count(1, "vertex") == "1 vertex"
    assert messages.count(2, "non-manifold vertex") == "2 non-manifold vertices"
    assert messages.changed({"regions": 2}, {"regions": 1}) == "2 regions -> 1 region"
    assert messages.changed({}, {"regions": 1}) == "1 region"
    assert messages.locked({"locked": 1}) == "1 region locked"
    assert messages.locked({}) == "No region is locked"
    assert messages.listed(["a", "b", "c"]) == "'a', 'b', 'c'"
    assert messages.listed(["a", "b", "c", "d"]) == "'a', 'b', 'c' and others"
    assert messages.dropped(1) == "1 edit by hand was dropped: Ctrl-Z brings it back"
    assert messages.dropped(12) == "12 edits by hand were dropped: Ctrl-Z brings them back"
    assert messages.partitioned({"triangles": 12, "regions": 1, "asked": 1}) == "12 triangles in 1 region"
    assert "3 more than requested" in messages.partitioned({"triangles": 12, "regions": 4, "asked": 1})


def test_hand_edits_are_the_steps_that_a_partition_drops():
    edits = (rcp.AddProxy(face=1), rcp.PaintFaces(faces=(1, 2)), rcp.Partition(proxies=2, faces=(1, 2)))
    recipe = rcp.Recipe((SPLIT, *edits, rcp.Mesh()))
    assert messages.hand_edits(recipe) == 3
    assert messages.hand_edits(recipe.replaced(1, rcp.AddProxy(face=1, enabled=False))) == 2
    assert messages.hand_edits(rcp.Recipe((SPLIT, edits[0], rcp.LockRegions(faces=(3,)), edits[0]))) == 1
    assert (
        messages.hand_edits(rcp.Recipe((SPLIT,))) == messages.hand_edits(rcp.Recipe()) == messages.hand_edits(None) == 0
    )


def test_what_mesh_does_again_is_no_edit_by_hand():
    recipe = rcp.Recipe((SPLIT, rcp.AddProxy(face=1), rcp.Regularise(), rcp.Mesh()))
    assert messages.hand_edits(recipe, regularises=True) == 1
    assert messages.hand_edits(recipe, regularises=False) == 2


def test_the_estimate_warns_that_planar_and_convex_polygons_are_more():
    numbers = {"regions": 4, "expected": {"polygons": 5, "regions": 4}}
    assert messages.expected(numbers).startswith("Mesh will make about 5 polygons, 1 more than regions")
    assert messages.expected(numbers, snaps=True).startswith("Mesh will make about 5 polygons or more")
    assert messages.expected(numbers, {"polygons": 7, "regions": 4}, snaps=True).startswith("Mesh will make 7 polygons")


def test_more_polygons_than_regions_are_explained():
    numbers = {
        "polygons": 558,
        "regions": 487,
        "split": {
            "split_for_holes": 40,
            "split_for_repair": 3,
            "split_for_odd": 9,
            "cut_to_be_planar": 2,
            "cut_to_be_convex": 7,
        },
    }
    assert (
        messages.why_more(numbers)
        == "71 more than regions: 40 with holes, 22 split because they bend, 7 cut to be convex, "
        "2 corners cut to keep faces flat"
    )
    numbers["split"]["without_area"] = 5
    assert "27 split because they bend, 7 cut to be convex, 5 fewer without area, 2 corners cut" in messages.why_more(
        numbers
    )
    assert messages.why_more({"polygons": 5, "regions": 4}) == "1 more than regions"
    assert messages.why_more({"polygons": 4, "regions": 4}) == ""


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (rcp.Partition(), "Partition, detail 0.5 %"),
        (rcp.Partition(proxies=1200), "Partition into 1,200"),
        (rcp.Partition(tolerance=0.2, faces=(1,)), "Partition 1 face, tolerance 0.2"),
        (rcp.AddProxy(face=5), "Add a region"),
        (rcp.PaintFaces(faces=(1, 2), lock=True), "Paint 2 faces into a new region, locked"),
        (rcp.EraseFaces(faces=(1,)), "Erase 1 face from a region"),
        (rcp.GrowRegion(face=5), "Grow a region by 1 ring"),
        (rcp.ShrinkRegion(face=5, rings=2), "Shrink a region by 2 rings"),
        (rcp.UnlockRegions(faces=(1,)), "Unlock 1 region"),
        (rcp.AddWorst(times=2), "Add 2 at the largest error"),
    ],
)
def test_a_step_in_the_list_names_no_face(step, said):
    assert messages.line(step) == said


def test_each_stage_of_the_engine_and_the_addon_has_a_name_that_is_translated():
    sources = [*ROOT.joinpath("native", "src").rglob("*.cpp"), *ROOT.joinpath("addon", "isimp").glob("*.py")]
    begin = r"(?:Stage [a-z_]*[({][a-z_.]*, *|watch\.part\(|engine_call\(watch, [^\"]*?)"
    found = {name for path in sources for name in re.findall(begin + r'"([a-z ]+)"', path.read_text(encoding="utf-8"))}
    found |= set(applying.STAGES.values())
    assert {"flooding", "reading the mesh", "measuring", "evening out"} <= found
    assert {name.capitalize() for name in found} == set(messages.STAGES)
