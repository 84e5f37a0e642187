"""Edits that act on other regions after the number of regions has changed."""

import numpy as np

from isimp import edit_shares
from isimp import recipe as rcp


def test_an_edit_is_counted_while_its_region_has_another_size():
    few, many = (np.arange(120) // size for size in (40, 10))
    edits = (rcp.PaintFaces(faces=(3, 4), onto=0), rcp.AddProxy(face=100), rcp.EvenBorders())
    first, second = (rcp.Recipe((rcp.Partition(proxies=count), *edits)) for count in (12, 3))
    made = edit_shares.compared(first, many, {})
    assert made["moved"] == []
    assert [share for _, share in made["edits"].values()] == [10 / 120] * 2
    other = edit_shares.compared(second, few, made)
    assert other["moved"] == [0, 100]
    assert edit_shares.compared(first, many, other) == made, "and back"
    similar = edit_shares.compared(second, np.arange(120) // 15, made)
    assert similar["moved"] == [], "by less than half"
    later = edit_shares.compared(rcp.Recipe((*second.steps, rcp.SplitRegion(face=50))), few, other)
    assert later["moved"] == [0, 100], "an edit made after it is no reason"


def test_faces_without_region_and_recipes_without_partition_are_fine():
    recipe = rcp.Recipe((rcp.Partition(proxies=2), rcp.AddProxy(face=9), rcp.AddProxy(face=0)))
    assert edit_shares.compared(recipe, np.array([-1, 0, 0]), {}) == {"edits": {}, "moved": []}
    assert edit_shares.compared(rcp.Recipe(), np.zeros(3, int), {}) == {"edits": {}, "moved": []}
