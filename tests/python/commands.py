"""The command `isimp` in a process of its own, or in this one: a process takes a third of a second to begin."""

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path

import isimp_engine as engine
from isimp_engine.cli import main

ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join([str(Path(engine.__file__).parents[1]), str(Path(__file__).parent)]),
    "COLUMNS": "100",
}


def isimp(*arguments, **keywords):
    command = [sys.executable, "-m", "isimp_engine", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=120, **keywords)


def called(*arguments, cwd="."):
    """As `isimp`, in this process."""
    out, err, before = io.StringIO(), io.StringIO(), Path.cwd()
    os.chdir(cwd)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main([str(argument) for argument in arguments])
    except SystemExit as ended:  # argparse's own errors
        status = ended.code
    finally:
        os.chdir(before)
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def ran(*arguments, cwd="."):
    """As `called`, for a command that has no error."""
    done = called(*arguments, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done


def check_line(done, status, *parts):
    """The command ended with a status and one line on stderr that holds all parts."""
    assert done.returncode == status, done.stderr
    assert done.stdout == ""
    line = done.stderr.splitlines()[-1]
    assert line.startswith("isimp")
    for part in parts:
        assert str(part) in line
    assert "Traceback" not in done.stderr
    if status == 3:
        assert len(done.stderr.splitlines()) == 1
