"""The recipe: steps as values, saved and read again."""

import dataclasses
import json

import pytest

from isimp import recipe as rcp
from isimp.recipe import AddProxy, DeleteProxy, Mesh, Partition, Recipe, RecipeError

FULL = Recipe(
    (
        Partition(proxies=7, seed=3, iterations=5, method="lloyd", seeding="farthest", leave_out=0.0),
        Partition(bound=0.1, seams=True, sharp=True, materials=True, angle=40.0, borders="groups", faces=(1, 2)),
        AddProxy(face=12),
        DeleteProxy(face=3, enabled=False),
        rcp.MergeRegions(face=1, other=2),
        rcp.SplitRegion(face=4),
        rcp.CutRegion(face=5, line=((0.1, 0.2, 0.3), (1.0, 2.0, 1e-17)), direction=(0.0, 0.0, -1.0)),
        rcp.PaintFaces(faces=(7, 8, 9), onto=3, lock=True),
        rcp.EraseFaces(faces=(1,)),
        rcp.SmoothFaces(faces=(1, 2), rounds=3),
        rcp.GrowRegion(face=2, rings=3),
        rcp.ShrinkRegion(face=2),
        rcp.LockRegions(faces=(1, 30)),
        rcp.UnlockRegions(faces=(1,)),
        rcp.LeaveOutRegions(faces=(4, 5), box=True),
        rcp.AddWorst(times=5),
        rcp.DeleteLeast(),
        rcp.MergeCheapest(),
        rcp.Improve(),
        rcp.EvenBorders(strength=0.5),
        rcp.RoundRegions(faces=(3, 4), kind="cone"),
        rcp.RoundSegments(face=3, segments=9, rings=2),
        rcp.ExplodeRound(face=3),
        rcp.Regularise(angle=5.0, direction=(0.0, 1.0, 0.0)),
        rcp.AlignPlanes(faces=(5, 9), to="parallel", length=0.01),
        Mesh(chord_tolerance=0.1, flatten=0),
        rcp.Texture(size=2048),
    )
)


def test_json_gives_back_every_kind_of_step():
    assert {type(step) for step in FULL.steps} == set(rcp.KINDS)
    assert Recipe.from_json(FULL.to_json()) == FULL
    assert Recipe.from_json(Recipe().to_json(indent=2)) == Recipe()


def test_a_texture_follows_polygons_and_is_removed_with_them():
    meshed = Recipe((Partition(proxies=6),)).then(Mesh())
    textured = meshed.then(rcp.Texture(size=64))
    assert [step.kind for step in textured.steps] == ["partition", "mesh", "texture"]
    assert textured.then(rcp.Texture()).steps[2].size == 0
    assert textured.ends_in_mesh()
    assert textured.texture().size == 64
    assert meshed.texture() is None
    assert textured.then(Mesh()) == meshed
    assert textured.without_mesh() == Recipe((Partition(proxies=6),))
    plain = textured.replaced(2, rcp.Texture(size=64, enabled=False))
    assert plain.texture() is None
    assert plain.ends_in_mesh()


def test_json_can_be_written_by_hand():
    text = '{"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": 6}, {"step": "mesh", "chord_tolerance": 1}]}'
    assert Recipe.from_json(text) == Recipe((Partition(proxies=6, adaptivity=0.0), Mesh(chord_tolerance=1)))


def test_steps_saved_before_a_setting_existed_keep_their_meaning():
    for step, name, value in ((Partition(proxies=6), "smooth", 0.0), (Mesh(), "join_junctions", 0.0)):
        saved = step.to_dict()
        assert rcp.step_from_dict(saved) == step
        del saved[name]
        assert getattr(rcp.step_from_dict(saved), name) == value != getattr(step, name)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not JSON"),
        pytest.param("[" * 200_000, "not a recipe: its brackets are nested too deeply", id="deep"),
        pytest.param('{"isimp_recipe": "' + "9" * 10**6 + '"}', "version '9+[.]{3}9+'", id="long"),
        ("[]", "no 'isimp_recipe'"),
        ('{"isimp_recipe": 99, "steps": []}', "version 99, this version of iSimp reads up to 1.*update iSimp"),
        ('{"isimp_recipe": 1}', "'steps' must be a list"),
    ],
)
def test_an_unreadable_recipe_has_the_reason(text, message):
    with pytest.raises(RecipeError, match=message):
        Recipe.from_json(text)


@pytest.mark.parametrize(
    ("kind", "settings", "message"),
    [
        ("melt", {}, "'melt' is not a step"),
        ("add_proxy", {"fase": 1}, "no setting 'fase'"),
        ("add_proxy", {"face": True}, "face of add_proxy must be a whole number"),
        ("add_proxy", {"face": -1}, "at least 0, got -1"),
        ("partition", {"proxies": 0}, "proxies must be at least 1, got 0"),
        ("partition", {"method": "magic"}, "method must be one of hierarchy, teleport"),
        ("partition", {"count_by": "luck"}, "one of detail, tolerance, bound, p"),
        ("partition", {"proxies": 3, "detail": 0.1}, "each set the number"),
        ("partition", {"detail": 2}, r"detail must be in \(0, 1\], got 2"),
        ("partition", {"leave_out": 1}, r"leave_out must be in \[0, 1\), got 1"),
        ("partition", {"angle": 190}, r"angle must be in \[0, 180\] degrees, got 190"),
        ("partition", {"tolerance": 0}, "a finite length above 0, got 0"),
        ("partition", {"weights": "\ud800"}, "characters that are not valid in a name"),
        ("paint", {}, r"faces must be a list of faces, got \(\)"),
        ("paint", {"faces": 3}, "faces of paint must be a list, got 3"),
        ("lock", {"faces": [1, 2.5]}, r"a list of faces, got \[1, 2.5\]"),
        ("erase", {"faces": [4, -2]}, "faces must be at least 0, got -2"),
        ("grow", {"rings": 0}, "rings must be at least 1, got 0"),
        ("grow", {"rings": 3000000000}, "rings of grow must be at most 2"),
        ("smooth", {"faces": [1], "rounds": 1001}, r"must be in \[1, 1,000\]"),
        ("even_borders", {"strength": 2}, r"strength must be in \[0, 1\], got 2"),
        ("add_worst", {"times": 0}, "times must be at least 1, got 0"),
        ("cut_region", {}, "line must have at least 2 points, got 0"),
        ("cut_region", {"line": [[10**400]]}, "a list of numbers"),
        ("cut_region", {"line": [[1, 2], [3, 4]]}, "each point of line must have 3 numbers"),
        ("cut_region", {"line": [[1, 2, "x"], [3, 4, 5]]}, "a point of line must be a list of numbers"),
        ("regularise", {"up": "down"}, "up must be one of scene, x, y, z, region, none, got 'down'"),
        ("regularise", {"angle": 46.0}, r"angle must be in \[0, 45\], got 46.0"),
        ("regularise", {"length": -1.0}, "length must be 0, or a finite length above 0, got -1.0"),
        ("regularise", {"direction": [1.0]}, "direction must have 3 numbers, got 1"),
        ("regularise", {"direction": [0, 0, 0]}, "direction must not be 0"),
        ("align", {}, "faces must be a list of faces"),
        ("align", {"faces": [1], "to": "flat"}, "to must be one of level, upright, parallel"),
        ("mesh", {"chord_tolerance": 0}, "chord_tolerance must be above 0"),
        ("mesh", {"chord_tolerance": float("nan")}, r"in \[0, 100\], got nan"),
        ("mesh", {"flatten": -1}, r"flatten must be in \[0, 10000\], got -1"),
        ("texture", {"size": 8}, r"size must be 0, or in \[16, 16384\], got 8"),
        ("texture", {"size": "big"}, "whole number"),
    ],
)
def test_a_wrong_step_has_its_place_and_the_reason(kind, settings, message):
    steps = [{"step": "mesh"}, {"step": kind, **settings}]
    with pytest.raises(RecipeError, match=f"^step 2: .*{message}"):
        Recipe.from_json(json.dumps({"isimp_recipe": 1, "steps": steps}))


def test_then_starts_over_at_a_partition_and_keeps_mesh_last():
    recipe = Recipe().then(Partition(proxies=3)).then(AddProxy(face=1)).then(Mesh())
    assert [step.kind for step in recipe.steps] == ["partition", "add_proxy", "mesh"]
    assert [step.kind for step in recipe.then(DeleteProxy(face=1)).steps] == ["partition", "add_proxy", "delete_proxy"]
    assert recipe.then(Mesh(flatten=1)).steps[-1] == Mesh(flatten=1)
    assert len(recipe.then(Mesh()).steps) == 3
    assert recipe.then(Partition(proxies=4)).steps == (Partition(proxies=4),)


def test_a_partition_keeps_the_steps_that_led_to_locked_regions():
    first, paint, more = Partition(proxies=3), rcp.PaintFaces(faces=(4, 5), lock=True), AddProxy(face=1)
    recipe = Recipe((first, AddProxy(face=2), paint, more, Mesh()))
    kept = recipe.then(Partition(detail=0.01))
    assert kept.steps == (first, AddProxy(face=2), paint, Partition(detail=0.01))
    assert kept.then(Partition(proxies=9)).steps == (first, AddProxy(face=2), paint, Partition(proxies=9))
    assert recipe.then(rcp.UnlockRegions(faces=(4,))).then(first).steps == (first,), "nothing is locked any more"
    for locks in (rcp.LockRegions(faces=(8,)), rcp.PaintFaces(faces=(1,), onto=8, lock=True)):
        assert len(Recipe((first, locks)).then(rcp.UnlockRegions(faces=(1,))).then(first).steps) == 4
        assert Recipe((first, dataclasses.replace(locks, enabled=False))).then(first).steps == (first,)


def test_a_changed_partition_follows_the_last_lock():
    first, more, lock, after = Partition(proxies=3), AddProxy(face=2), rcp.LockRegions(faces=(8,)), AddProxy(face=5)
    new = Partition(proxies=9)
    assert Recipe((first, more, after)).changed(0, new).steps == (new, more, after), "nothing is locked"
    changed = Recipe((first, more, lock, after)).changed(0, new)
    assert changed.steps == (first, more, lock, new, after)
    newer = Partition(proxies=10)
    assert changed.changed(3, newer).steps == (first, more, lock, newer, after)
    part = Partition(proxies=2, faces=(1, 2))
    assert Recipe((first, Partition(faces=(1, 2)), lock)).changed(1, part).steps == (first, part, lock)
    assert Recipe((first, lock, after)).changed(2, more).steps == (first, lock, more)


def test_a_partition_of_a_part_follows_other_steps_and_replaces_itself():
    whole, part = Partition(proxies=3), Partition(proxies=5, faces=(1, 2))
    recipe = Recipe((whole,)).then(part)
    assert recipe.steps == (whole, part)
    assert recipe.then(Partition(proxies=7, faces=(1, 2))).steps == (whole, Partition(proxies=7, faces=(1, 2)))
    assert recipe.then(Partition(faces=(3,))).steps == (whole, part, Partition(faces=(3,)))
    assert Partition(faces=(3,)).describe() == "Partition face 3 at detail 0.005"


def test_the_given_count_selects_count_by():
    assert (Partition().count_by, Partition().adaptivity) == ("detail", 0.25)
    for name in rcp.COUNTS:
        assert Partition(**{name: 2 if name in ("proxies", "triangles") else 0.5}).count_by == name
    assert Partition(count_by="bound", proxies=3).count_by == "bound"
    assert rcp.step_from_dict({"step": "partition", "proxies": 6}) == Partition(proxies=6, adaptivity=0.0)
    with pytest.raises(
        RecipeError, match="tolerance, proxies each set the number of regions: give one of them, or count_by"
    ):
        Partition(proxies=3, tolerance=0.1)


def test_the_layers_that_a_recipe_needs():
    recipe = Recipe((Partition(weights="w", borders="b", seams=True), Partition(materials=True, enabled=False)))
    assert recipe.layers() == {"w", "b", ".seam"}
    assert Recipe((Partition(sharp=True, materials=True, face_sets=True),)).layers() == {
        ".sharp",
        ".material",
        ".face_set",
    }


def test_keys_depend_on_earlier_steps_and_not_on_steps_switched_off():
    first, second = Partition(proxies=3), AddProxy(face=1)
    keys = Recipe((first, second)).prefix_keys()
    assert Recipe((first,)).prefix_keys() == keys[:1]
    assert Recipe((first, DeleteProxy(face=9, enabled=False), second)).prefix_keys() == keys
    assert Recipe((Partition(proxies=4), second)).prefix_keys()[1] != keys[1]
    assert len(set(keys)) == 2


def test_a_step_switched_off_is_saved_as_such():
    values = json.loads(FULL.to_json())["steps"]
    assert [values[3].get("enabled"), "enabled" in values[2]] == [False, False]
    assert [index for index, _ in FULL.active()] == [0, 1, 2, *range(4, len(FULL.steps))]


def test_a_recipe_without_its_mesh():
    regions = Recipe((Partition(), AddProxy(face=3)))
    meshed = regions.then(Mesh())
    assert meshed.without_mesh() == regions == regions.without_mesh()
    assert (meshed.ends_in_mesh(), regions.ends_in_mesh(), Recipe().ends_in_mesh()) == (True, False, False)
    assert not Recipe((*regions.steps, Mesh(enabled=False))).ends_in_mesh()


def test_every_step_describes_itself():
    words = [step.describe() for step in FULL.steps]
    assert len(set(words)) == len(words)
    assert "Paint 3 faces into the region at face 3, locked" in words
    assert "Erase face 1 from the region at face 1" in words


def test_faces_may_come_from_any_sequence_of_integers():
    numpy = pytest.importorskip("numpy")
    assert rcp.PaintFaces(faces=numpy.array([3, 4])) == rcp.PaintFaces(faces=[3, 4]) == rcp.PaintFaces(faces=(3, 4))
    with pytest.raises(RecipeError, match="faces must be at least 0, got -1"):
        rcp.PaintFaces(faces=(3, -1))


def test_steps_are_replaced():
    a, b, c = Partition(), AddProxy(face=1), AddProxy(face=2)
    recipe = Recipe((a, b, c))
    assert recipe.replaced(1, AddProxy(face=9)).steps == (a, AddProxy(face=9), c)
    for index in (3, -1):
        with pytest.raises(RecipeError, match=r"there is no step -?\d: the recipe has 3"):
            recipe.replaced(index, b)


def test_a_recipe_of_a_larger_scan_has_larger_lengths_and_places():
    part = Partition(tolerance=0.5, keep_openings=((1, -2, 3),), more=((1, 2, 3, 4),))
    align = rcp.AlignPlanes(faces=(1,), length=0.5, direction=(0, 1, 0))
    places = rcp.Places(8, 9, (1,), ((1, 2, 3),), ((0, 0, 1),), (0.5,))
    recipe = Recipe((*FULL.steps, part, align), places)
    larger = recipe.scaled(4)
    assert larger.scaled(0.25) == recipe
    assert (larger.places.size, larger.places.points, larger.places.normals) == (32, ((4, 8, 12),), ((0, 0, 1),))
    assert larger.steps[6].line == ((0.4, 0.8, 1.2), (4.0, 8.0, 4e-17))
    assert larger.steps[-2:] == (
        dataclasses.replace(part, tolerance=2, bound=4, keep_openings=((4, -8, 12),), more=((4, 8, 12, 16),)),
        dataclasses.replace(align, length=2),
    )
