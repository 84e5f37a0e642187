"""bench/studies/gpu.py, which is for machines with a device, runs on the processor too, and judges rightly."""

import csv
import stat

import isimp_engine as engine
from bench.studies import gpu


def test_the_whole_command_on_a_small_surface(tmp_path, capsys):
    tests = tmp_path / "tests"
    tests.mkdir()
    for name in gpu.TESTS:
        (tests / name).write_text("#!/bin/sh\necho '[  PASSED  ] 3 tests.'\n")
        (tests / name).chmod(stat.S_IRWXU)
    small = ["--faces", "1200,2500", "--counts", "10,20", "--repeat", "1"]
    assert gpu.main(["--out", str(tmp_path / "out"), "--tests", str(tests), *small]) == 0
    with (tmp_path / "out" / "times.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * (2 + 2 * len(engine.backends()))
    assert all(row["same_as_cpu"] == "True" and not row["problem"] for row in rows)
    assert {row["speed_up"] for row in rows if row["method"] == "lloyd"} == {"1.0"}
    with (tmp_path / "out" / "checks.csv").open(newline="") as file:
        assert {row["program"] for row in csv.DictReader(file)} == set(gpu.TESTS)
    printed = capsys.readouterr().out
    assert printed.startswith("| mesh | P | lloyd, cpu | default, cpu | queued, cpu |")
    if "cuda" not in engine.backends():
        assert "there is no device" in printed


def test_a_failing_test_fails_the_whole(tmp_path, capsys):
    for name in gpu.TESTS:
        (tmp_path / name).write_text("#!/bin/sh\necho '1 FAILED TEST'\nexit 1\n")
        (tmp_path / name).chmod(stat.S_IRWXU)
    small = ["--faces", "1200", "--counts", "10", "--repeat", "1"]
    assert gpu.main(["--out", str(tmp_path), "--tests", str(tmp_path), *small]) == 1
    assert "test_parallel under plain failed: 1 FAILED TEST" in capsys.readouterr().out


def row(method, backend, seconds, **more):
    base = {
        "mesh": "ring",
        "faces": 1_000_000,
        "proxies": 100,
        "method": method,
        "backend": backend,
        "again_s": seconds,
    }
    return base | {"speed_up": 2 / seconds, "same_as_cpu": True, "problem": ""} | more


def test_the_verdict_names_the_questions_to_the_device():
    base = [row("lloyd", "cpu", 2.0), row("default", "cpu", 0.1)]
    good = gpu.verdict([*base, row("queued", "cuda", 0.05), row("naive", "cuda", 0.2)], [])
    assert good == [
        "queued at a million faces: 40.0 to 40.0 times lloyd; the aim is 20",
        "faster than the default on one thread in 1 of 2 cases",
    ]
    bad = gpu.verdict(
        [*base, row("queued", "cuda", 0.5, same_as_cpu=False), row("naive", "cuda", 1, problem="full")], []
    )
    assert bad[:2] == ["naive, ring, P 100: full", "queued, ring, P 100: not the processor's labels"]
