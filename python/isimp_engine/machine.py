"""The share of its machine that this process may use: limits of the system's groups of processes count too."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

_MB = 1 << 20


def cores() -> int:
    """The number of threads that can work at once."""
    try:
        count = len(os.sched_getaffinity(0))
    except AttributeError:  # macOS
        count = os.cpu_count() or 1
    for group in _groups():
        text = _text(group / "cpu.max").split()
        if len(text) == 2 and text[0] != "max":
            count = min(count, max(1, round(int(text[0]) / int(text[1]))))
    return max(1, count)


def memory_mb() -> float:
    """The free memory for new work, MB; the system's cache of files counts as free."""
    lines = _text(Path("/proc/meminfo")).splitlines()
    found = [int(line.split()[1]) / 1024 for line in lines if line.startswith("MemAvailable:")]
    for group in _groups():
        most, now = _text(group / "memory.max").strip(), _text(group / "memory.current").strip()
        if most.isdigit() and now.isdigit():
            files = [line.split()[1] for line in _text(group / "memory.stat").splitlines() if line.startswith("file ")]
            found.append((int(most) - int(now) + int(files[0] if files else 0)) / _MB)
    if found:
        return max(0.0, min(found))
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / _MB / 2
    except (ValueError, OSError, AttributeError):
        return 2048.0


def memory_of(process: int | str) -> dict[str, float]:
    """The MB of each kind of memory of a process; empty if it has ended, or the system does not provide them."""
    lines = _text(Path(f"/proc/{process}/status")).splitlines()
    return {line.split(":")[0]: int(line.split()[1]) / 1024 for line in lines if line.endswith(" kB")}


def peak_mb() -> float | None:
    """The peak memory of this process; None if the system has no such number."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    return round(memory_of("self").get("VmHWM", peak), 1)  # that number of Linux may be the one of the parent process


def _groups() -> Iterator[Path]:
    """The control groups (version 2) that this process is in, from its own to the root."""
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        if line.startswith("0::/"):
            root = Path("/sys/fs/cgroup")
            group = root / line[4:].strip("/")
            yield from (group, *(each for each in group.parents if each.is_relative_to(root)))


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
