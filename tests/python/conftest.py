import os
import signal
from pathlib import Path

import pytest

import isimp_engine as engine
import shapes

ROOT = Path(__file__).resolve().parents[2]

# Where the tests were started in the background Ctrl-C is ignored, in the commands they run too; some test just that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def cube():
    """The unit cube of 192 faces."""
    return engine.Mesh(*shapes.cube())


@pytest.fixture(scope="session")
def sheet():
    """An open, curved sheet of 7200 faces."""
    return engine.Mesh(*shapes.bumpy())


@pytest.fixture(scope="session")
def data():
    """The folder of real meshes, named by ISIMP_DATA or beside the repository; without it the test is skipped."""
    folder = Path(os.environ.get("ISIMP_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real meshes: {folder} is absent (set ISIMP_DATA)")
    return folder
