"""Work for a batch that crashes, hangs or takes too much, chosen by the name of the scan; else it simplifies."""

import errno
import os
import signal
import time
from pathlib import Path

from isimp_engine.batch import work


def run(task, folder):
    name = Path(task["input"]).stem
    if log := os.environ.get("ODD_WORK_LOG"):  # one line for each scan that is begun
        with open(log, "a") as file:  # noqa: PTH123
            file.write(f"{name} {os.getpid()}\n")
    if name.startswith("crash"):
        os.kill(os.getpid(), signal.SIGSEGV)
    if name.startswith("hang"):
        time.sleep(600)
    if name.startswith("large"):
        taken = [bytearray(b"x" * (16 << 20)) for _ in range(1000)]
        return {"faces": len(taken)}
    if name.startswith("exit"):
        os.write(2, b"first line\nno licence for this machine\n")
        os._exit(9)
    if name.startswith("raise"):
        raise KeyError("a mistake in the work")
    if name.startswith("full"):  # the disk is full from now on

        def write_text(*_, **__):
            raise OSError(errno.ENOSPC, "No space left on device")

        Path.write_text = Path.write_bytes = write_text
        return work.simplify(task, folder) if task["picture"] else {"faces": 1}
    if name.startswith("slow"):
        time.sleep(0.4)
    return work.simplify(task, folder)
