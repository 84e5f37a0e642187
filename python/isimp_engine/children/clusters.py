"""Clusters that a run starts for itself: jobs of a batch system by dask-jobqueue, or machines by SSH."""

import importlib
import json
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from .errors import BatchError, line_of

JOBS = {  # kinds with jobs as workers: module and class of dask-jobqueue
    "slurm": ("dask_jobqueue", "SLURMCluster"),
    "pbs": ("dask_jobqueue", "PBSCluster"),
    "sge": ("dask_jobqueue", "SGECluster"),
    "lsf": ("dask_jobqueue", "LSFCluster"),
    "local": ("dask_jobqueue.local", "LocalCluster"),  # jobs are processes of this machine, for trials
}
KINDS = (*JOBS, "ssh")
_SHARE = 0.9  # share of a job's memory for children; the rest is for the worker itself
_UNITS = {"B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
_UNITS |= {"KIB": 2**10, "MIB": 2**20, "GIB": 2**30, "TIB": 2**40}


class Cluster(NamedTuple):
    """A cluster to start."""

    kind: str  #: one of KINDS
    workers: int = 1  #: number of jobs; `ssh` starts one on each host except the first
    options: dict[str, Any] = {}  # noqa: RUF012  #: for the cluster's class: cores, memory, walltime, queue, hosts, ...


def option(text: str) -> tuple[str, Any]:
    """Parse an option NAME=VALUE of the command line. VALUE is JSON, such as a number or a list, else a text."""
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise BatchError(f"--cluster-option must be NAME=VALUE, got {text!r}")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


def checked(kind: str | None, workers: int | None, options: Sequence[str]) -> Cluster | None:
    """Return the cluster from the options of the command line; None without `--cluster`. Raises BatchError."""
    if kind is None:
        if workers is not None or options:
            raise BatchError("--workers and --cluster-option belong to --cluster")
        return None
    if kind not in KINDS:
        raise BatchError(f"--cluster must be one of {', '.join(KINDS)}, got {kind!r}")
    if workers is not None and workers < 1:
        raise BatchError(f"--workers must be at least 1, got {workers}")
    return Cluster(kind, workers or 1, dict(map(option, options)))


@contextmanager
def started(cluster: Cluster) -> Iterator[str]:
    """Start a cluster. Yields the address of its scheduler, and ends its jobs after the block. Raises BatchError."""
    make = _ssh if cluster.kind == "ssh" else _jobs
    found = make(cluster)
    try:
        yield str(found.scheduler_address)
    finally:
        found.close()


def _class_of(kind: str, module: str, name: str, package: str) -> Any:
    kept = signal.getsignal(signal.SIGINT)
    try:
        return getattr(importlib.import_module(module), name)
    except ImportError:
        needs = f"--cluster {kind} needs the package {package}: pip install 'isimp[cluster]'"
        raise BatchError(needs) from None
    finally:
        if signal.getsignal(signal.SIGINT) is not kept:  # dask_jobqueue makes Ctrl-C a SystemExit
            signal.signal(signal.SIGINT, kept)


def _jobs(cluster: Cluster) -> Any:
    kind, options = cluster.kind, dict(cluster.options)
    make = _class_of(kind, *JOBS[kind], "dask-jobqueue")
    options.setdefault("processes", 1)  # a job is one worker, with threads that wait for children
    options.setdefault("nanny", False)
    if "memory" in options:
        extra = list(options.get("worker_extra_args", ()))
        options["worker_extra_args"] = [*extra, "--resources", f"MB={megabytes(options['memory']) * _SHARE:.0f}"]
    try:
        found = make(**options)
        found.scale(jobs=cluster.workers)
    except (TypeError, ValueError, OSError, RuntimeError) as error:
        raise BatchError(f"--cluster {kind} can't be started: {line_of(error)}") from None
    return found


def _ssh(cluster: Cluster) -> Any:
    options = dict(cluster.options)
    hosts = options.pop("hosts", None)
    hosts = hosts.split(",") if isinstance(hosts, str) else hosts
    if not isinstance(hosts, list) or len(hosts) < 2:
        raise BatchError("--cluster ssh needs --cluster-option hosts=SCHEDULER,WORKER,... : two hosts or more")
    make = _class_of("ssh", "distributed", "SSHCluster", "distributed")
    _class_of("ssh", "asyncssh", "connect", "asyncssh")
    worker: dict[str, Any] = {"nthreads": int(options.pop("cores"))} if "cores" in options else {}
    if "memory" in options:
        worker["resources"] = {"MB": megabytes(options.pop("memory")) * _SHARE}
    try:
        return make(hosts, worker_options=worker | options.pop("worker_options", {}), **options)
    except (TypeError, ValueError, OSError, RuntimeError) as error:
        raise BatchError(f"--cluster ssh can't be started: {line_of(error)}") from None


def megabytes(text: str | float) -> float:
    """Convert `60GB`, `64 GiB` or a number of bytes to MB of 2^20 bytes. Raises BatchError."""
    if isinstance(text, str):
        digits = text.strip().rstrip("BKMGTIbkmgti ")
        unit = text.strip()[len(digits) :].strip().upper() or "B"
        unit = unit if unit.endswith("B") else unit + "B"
        try:
            return float(digits) * _UNITS[unit] / 2**20
        except (KeyError, ValueError):
            raise BatchError(f"memory must be a number of bytes like 60GB, got {text!r}") from None
    return float(text) / 2**20
