"""Twenty seconds of the Python module's monkey, bench/monkeys/monkey.py, long chains of its edits, and its judges."""

import os
import signal
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import isimp_engine as engine
import shapes

pytest.importorskip("resource", reason="each case is a fork with limits, as POSIX has them")
from bench.monkeys import draws, judging, monkey

# Both tests need twenty seconds of the processor. A new option or edit changes the draws of all cases.
MADE_SEED, MADE_CASES = 5, range(70)
FILE_SEED, FILE_CASES = 3, range(40)
FACES = 1000


def found(seed, cases, **keywords):
    return monkey.run(seed, iter(cases), jobs=2, most=FACES, **keywords)


@pytest.mark.slow
def test_made_scans_hold():
    findings, done = found(MADE_SEED, MADE_CASES, with_files=False)
    assert findings == []
    assert done["meshed"] > 0.6 * done["cases"]
    assert set(monkey.WAYS) <= set(done)
    assert set(draws.functions()) <= set(done), "every edit was made"


@pytest.mark.slow
def test_files_hold(data):
    assert len(draws.files()) > 10
    findings, done = found(FILE_SEED, FILE_CASES)
    assert findings == []
    assert done["meshed"] > 0.6 * done["cases"]


def chained(mesh, part, edits, seed):
    """Makes edits, drawn and judged as the monkey's, one after another, with steps back.

    Returns how many were done of each, and the memory in MB at a tenth, the middle and the end.
    """
    surface, rng = judging.Surface(mesh), np.random.default_rng(seed)
    earlier, done, memory = [part], Counter(), []
    for number in range(edits):
        if number in (edits // 10, edits // 2):  # the first edits set up the kept data
            memory.append(resident_mb())
        if rng.random() < 0.1:
            part = earlier[rng.integers(len(earlier))]
        edit = draws.edit(mesh, part, rng)
        try:
            after = edit.run(mesh, part)
        except engine.InvalidInput:
            continue
        findings = [*judging.edit_findings(edit, part, after), *judging.partition_findings(surface, after)]
        assert findings == [], f"edit {number} of seed {seed}: {edit.name}"
        part, earlier = after, [*earlier[-20:], after]
        done[edit.name] += 1
    return done, [*memory, resident_mb()]


def resident_mb():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


@pytest.mark.slow
def test_a_long_chain_of_edits_keeps_every_promise():
    mesh = engine.Mesh(*shapes.bumpy(40))
    done, _ = chained(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=30)), 400, seed=1)
    assert set(draws.functions()) - set(draws.ROUND_EDITS) <= set(done), "some kind of edit was never done"


@pytest.mark.slow
def test_edits_next_to_parts_that_were_left_out():
    speck = shapes.plane(1)
    mesh = engine.Mesh(*shapes.joined(shapes.cube(8), shapes.torus(), (speck[0] * 0.01 + 3, speck[1])))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=20))
    assert (part.face_region == -1).any()
    chained(mesh, part, 200, seed=2)


@pytest.mark.slow
def test_memory_does_not_grow_with_edits_of_a_scan(data):
    mesh = engine.clean(*engine.read(data / "scan" / "bunny_69k.ply"))
    _, memory = chained(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=200)), 25, seed=3)
    assert memory[2] < memory[1] * 1.05 + 10, f"memory grows: {memory} MB"


def never_ends(*arguments):
    while True:
        pass


def crashes(*arguments):
    os.kill(os.getpid(), signal.SIGSEGV)


def raises(*arguments):
    raise RuntimeError("a fault")


@pytest.mark.parametrize(
    ("fault", "text"), [(never_ends, "at clean"), (crashes, "ended by signal 11, at clean"), (raises, "a fault")]
)
def test_what_ends_a_case_is_found(monkeypatch, fault, text):
    monkeypatch.setattr(engine, "clean", fault)
    monkeypatch.setattr(monkey, "SECONDS", 1)
    ((case, finding),), done = found(1, [7], with_files=False)
    assert case == 7
    assert text in finding
    assert done["cases"] == 1


def test_a_finding_has_the_command_that_repeats_it(monkeypatch, capfd):
    monkeypatch.setattr(engine, "clean", raises)
    assert monkey.main(["--seed", "3", "--case", "5", "--made"]) == 1
    line = capfd.readouterr().out.splitlines()[0]
    assert line.startswith("RuntimeError: a fault")
    assert line.endswith("| python -m bench.monkeys.monkey --seed 3 --made --case 5")


def test_a_case_is_drawn_from_its_numbers_alone():
    texts = []
    for _ in range(2):
        one = monkey.Monkey(2, 4, 500, False, lambda step: None)
        one.run()
        texts.append(one.case.text)
    assert texts[0] == texts[1]


def test_every_option_and_every_edit_can_be_drawn():
    mesh = engine.Mesh(*shapes.cube())
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    for seed in range(20):
        rng = np.random.default_rng(seed)
        for kind in (engine.CleanOptions, engine.PartitionOptions, engine.MeshingOptions, engine.RegulariseOptions):
            assert draws.options(kind, rng, 1.0, 192, share=1.0) is not None
        for name in draws.functions():
            edit = draws.edit(mesh, part, rng, name)
            assert set(edit.arguments) == set(draws.functions()[name]) - {"job"}
    assert set(judging.PROMISES) | judging.CHANGE_LOCKED <= set(draws.functions())
    assert {"add_proxy", "regularise", "make_round"} <= set(draws.functions())


@pytest.fixture
def model():
    mesh = engine.Mesh(*shapes.cube())
    part = engine.partition(mesh, engine.PartitionOptions(bound=0.01))
    return judging.Surface(mesh), part, engine.polygonize(mesh, part)


def changed(thing, **values):
    """The same with other values."""
    names = [name for name in dir(type(thing)) if not name.startswith("_")]
    return SimpleNamespace(**{name: values.get(name, getattr(thing, name)) for name in names})


def test_the_judge_of_partitions_sees_what_is_wrong(model, monkeypatch):
    surface, part, _ = model
    known = engine.regions.all_statistics(surface.mesh, part)
    monkeypatch.setattr(engine.regions, "all_statistics", lambda mesh, part: known)

    def texts(**values):
        return " ".join(judging.partition_findings(surface, changed(part, **values)))

    assert texts() == ""
    label = np.array(part.face_region)
    away = surface.vertices[surface.triangles].mean(axis=1)
    away = np.linalg.norm(away - away[label == 0].mean(axis=0), axis=1)
    label[np.argmax(away)] = 0
    assert "are not connected" in texts(face_region=label)
    assert "labels" in texts(face_region=label + 1)
    assert "neither unit nor zero" in texts(region_normal=2 * np.array(part.region_normal))
    assert "not finite" in texts(region_offset=np.nan * np.array(part.region_offset))
    assert "in truth 0.25" in texts(region_offset=np.array(part.region_offset) + 0.25)
    assert "above the bound" in texts(bound=-1e-3)
    assert "seed" in texts(region_seed=np.roll(part.region_seed, 1))


def test_the_judge_of_polygons_sees_what_is_wrong(model):
    surface, part, poly = model

    def texts(**values):
        options = engine.MeshingOptions()
        return " ".join(judging.polygon_findings(surface, part, changed(poly, **values), options))

    assert texts() == ""
    moved = np.array(poly.vertices)
    moved[0] += 0.3
    assert "out of reach" in texts(vertices=moved)
    assert "planarity of polygon" in texts(vertices=moved)
    assert "closed" in texts(report=poly.report | {"closed": False})
    assert "corners" in texts(report=poly.report | {"corners": 7})
    assert "has none" in texts(polygon_region=np.zeros_like(poly.polygon_region))
    loops = np.array(poly.loops)
    loops[:4] = loops[3::-1]
    assert "manifold True, in truth False" in texts(loops=loops)
    moved[0] = np.nan
    assert "not finite" in texts(vertices=moved)


def test_the_judge_of_edits_sees_what_is_wrong(model):
    surface, part, _ = model
    mesh = surface.mesh
    split = engine.split_region(mesh, part, 0)

    def texts(name, after, before=part, **arguments):
        return " ".join(judging.edit_findings(draws.Edit(name, arguments), before, after))

    assert texts("split_region", split, face=0) == ""
    assert "not +1: +0" in texts("split_region", part, face=0)
    assert "not -1: +1" in texts("delete_proxy", split, face=0)
    other = int(np.flatnonzero(np.asarray(part.face_region) != part.face_region[0])[0])
    assert "changes more" in texts("split_region", engine.split_region(mesh, part, other), face=0)
    locked = engine.lock_regions(mesh, part, np.array([0]))
    assert f"locked region {part.face_region[0]} has changed" in texts("improve", split, before=locked)
