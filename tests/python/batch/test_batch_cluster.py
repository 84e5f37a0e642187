"""`--cluster`: clusters that are started for one run, as jobs or by SSH."""

import importlib.util
import os
import signal
import subprocess
import sys
import types
from typing import ClassVar

import pytest

from commands import called
from isimp_engine import batch
from isimp_engine.children import clusters
from test_batch_dask import ENVIRONMENT, make_scans


class Recorded:
    """A replacement for a cluster of Dask that records its arguments."""

    made: ClassVar[list] = []

    def __init__(self, *arguments, **options):
        self.arguments, self.options, self.jobs, self.closed = arguments, options, None, False
        if "nonsense" in options:
            raise TypeError("no option 'nonsense'")
        self.scheduler_address = "tcp://127.0.0.1:1"
        Recorded.made.append(self)

    def scale(self, jobs):
        self.jobs = jobs

    def close(self):
        self.closed = True


@pytest.fixture
def recorded(monkeypatch):
    Recorded.made.clear()
    monkeypatch.setitem(sys.modules, "dask_jobqueue", types.SimpleNamespace(SLURMCluster=Recorded))
    monkeypatch.setitem(sys.modules, "distributed", types.SimpleNamespace(SSHCluster=Recorded))
    monkeypatch.setitem(sys.modules, "asyncssh", types.SimpleNamespace(connect=None))
    return Recorded.made


def test_slurm_gets_jobs_with_memory_as_a_resource_and_they_end_with_the_run(recorded):
    given = ["cores=16", "memory=60GB", "walltime=04:00:00", "queue=long", 'job_extra_directives=["--qos=low"]']
    with clusters.started(clusters.checked("slurm", 3, given)) as address:
        assert address == "tcp://127.0.0.1:1"
        assert not recorded[0].closed
    found = recorded[0]
    assert (found.jobs, found.closed) == (3, True)
    assert found.options.pop("worker_extra_args") == ["--resources", f"MB={60e9 / 2**20 * 0.9:.0f}"]
    assert found.options == {
        "cores": 16,
        "memory": "60GB",
        "walltime": "04:00:00",
        "queue": "long",
        "job_extra_directives": ["--qos=low"],
        "processes": 1,
        "nanny": False,
    }


def test_ssh_gets_hosts_and_the_block_s_error_ends_it_too(recorded):
    plan = clusters.checked("ssh", None, ["hosts=a,b,c", "cores=8", "memory=16GiB"])
    with pytest.raises(ZeroDivisionError), clusters.started(plan):
        raise ZeroDivisionError
    found = recorded[0]
    assert found.arguments == (["a", "b", "c"],)
    assert found.options == {"worker_options": {"nthreads": 8, "resources": {"MB": 16 * 1024 * 0.9}}}
    assert found.closed


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("cloud", None, ()), "--cluster must be one of slurm, pbs, sge, lsf, local, ssh, got 'cloud'"),
        ((None, 2, ()), "belong to --cluster"),
        (("slurm", 0, ()), "--workers must be at least 1, got 0"),
        (("slurm", 1, ("cores",)), "must be NAME=VALUE, got 'cores'"),
        (("slurm", 1, ("memory=much",)), "memory must be a number of bytes like 60GB, got 'much'"),
        (("slurm", 1, ("nonsense=1",)), "--cluster slurm can't be started: TypeError: no option 'nonsense'"),
        (("ssh", 1, ("hosts=a",)), "two hosts or more"),
    ],
)
def test_what_is_wrong_is_said(recorded, arguments, said):
    with pytest.raises(batch.BatchError) as caught, clusters.started(clusters.checked(*arguments)):
        pass
    assert said in str(caught.value)


@pytest.mark.parametrize(("kind", "package"), [("slurm", "dask_jobqueue"), ("ssh", "distributed"), ("ssh", "asyncssh")])
def test_an_absent_package_is_named(recorded, monkeypatch, kind, package):
    monkeypatch.setitem(sys.modules, package, None)
    needed = package.replace("_", "-")
    with (
        pytest.raises(batch.BatchError, match=rf"needs the package {needed}: pip install 'isimp\[cluster\]'"),
        clusters.started(clusters.checked(kind, 1, ["hosts=a,b"])),
    ):
        pass


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")
def test_the_commands_take_clusters_and_refuse_two(tmp_path):
    scans = make_scans(tmp_path / "in", "a.ply")
    for command in (("batch", scans, tmp_path / "out"), ("tiles", scans, tmp_path / "o.ply", "--proxies", 6)):
        done = called(*command, "--cluster", "slurm", "--dask", "tcp://a:1")
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert "--dask and --cluster contradict each other" in done.stderr


def test_a_package_that_takes_ctrl_c_gives_it_back(tmp_path, monkeypatch):
    text = "import signal, sys\nsignal.signal(signal.SIGINT, lambda *_: sys.exit())\nclass SLURMCluster: pass\n"
    (tmp_path / "greedy_jobqueue.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    before = signal.getsignal(signal.SIGINT)
    assert clusters._class_of("slurm", "greedy_jobqueue", "SLURMCluster", "greedy").__name__ == "SLURMCluster"
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")
def test_jobs_of_this_machine_do_a_batch(tmp_path):
    """The real classes of dask-jobqueue, with a script of a job that is run here."""
    if importlib.util.find_spec("dask_jobqueue") is None:  # an import would take Ctrl-C from the other tests
        pytest.skip("dask_jobqueue is not installed")
    scans = make_scans(tmp_path / "in", "a.ply", "b.ply")
    options = ["cores=2", "memory=1GB", f"local_directory={tmp_path}", f"log_directory={tmp_path}"]
    options += ['scheduler_options={"dashboard_address": null, "host": "127.0.0.1"}', f"python={sys.executable}"]
    command = [sys.executable, "-m", "isimp_engine", "batch", scans, tmp_path / "out", "--proxies", 6, "--no-pictures"]
    command += ["--cluster", "local", *(word for text in options for word in ("--cluster-option", text))]
    path = [ENVIRONMENT["PYTHONPATH"], *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(path)}
    done = subprocess.run([*map(str, command)], env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert [row["status"] for row in batch.table.read_rows(tmp_path / "out")] == ["ok", "ok"]
