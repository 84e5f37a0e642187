"""`isimp tiles` on the workers of a Dask cluster gives the same bits, also when one of them is killed."""

import os
import subprocess
import sys

import pytest

import tilesets
from batches import wait_for
from commands import ENVIRONMENT, ran
from test_batch_dask import cluster  # noqa: F401  (a fixture)

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")


def test_workers_of_a_cluster_give_the_same_bits_also_when_one_is_killed(tmp_path, cluster):  # noqa: F811
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*tilesets.hilly(32), 2, 2))
    options = ["--proxies", 8, "--quiet"]
    address, processes = cluster("--nthreads", "1", workers=2)
    command = [sys.executable, "-m", "isimp_engine", "tiles", folder, tmp_path / "a.ply", *options]
    command += ["--dask", address, "--work", tmp_path / "work"]
    process = subprocess.Popen([*map(str, command)], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    wait_for((tmp_path / "work" / "mend").exists)
    processes[-1].kill()
    said = process.communicate(timeout=120)[1]
    assert process.returncode == 0, said
    ran("tiles", folder, tmp_path / "b.ply", *options)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
