"""A real window of Debian's Blender under Xvfb, driven by simulated mouse and keys.

Two scenarios make pictures, in out/window; with ISIMP_WINDOW_OUT set all do, in the folder that it names.
"""

import os
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[3]
OUT = Path(os.environ.get("ISIMP_WINDOW_OUT", ROOT / "out" / "window"))
SIZE = 640, 1150  # pixels: the whole panel is visible
SMALL = 360, 460  # for scenarios without buttons: less to draw
WITHOUT_BUTTONS = {"gestures", "live", "paint", "pieces", "tools"}
OTHER_SIZES = {"off_scan": (640, 512), "compare": (1000, 900), "jobs": (800, 960)}
OF_PICTURES = {"bunny", "compare"}
LIMIT = 600  # seconds; one or two minutes on a quiet machine


def site():
    """The folder where a Blender finds the add-on and the packages of this Python."""
    return os.pathsep.join(
        [
            str(ROOT / "addon"),
            *(path for path in sys.path if path.endswith("-packages")),
            os.environ.get("PYTHONPATH", ""),
        ]
    )


@pytest.mark.parametrize("scenario", sorted(path.stem.removeprefix("scenario_") for path in HERE.glob("scenario_*.py")))
def test_scenario(scenario):
    missing = [name for name in ("blender", "xvfb-run", "import") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"needs {', '.join(missing)} (Debian: blender, xvfb, imagemagick)")
    OUT.mkdir(parents=True, exist_ok=True)
    size = SMALL if scenario in WITHOUT_BUTTONS else OTHER_SIZES.get(scenario, SIZE)
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", *map(str, size)]
    script = ["--python", str(HERE / "drive.py"), "--", str(HERE / f"scenario_{scenario}.py"), str(OUT)]
    command = ["xvfb-run", "-a", "-s", f"-screen 0 {size[0]}x{size[1]}x24", *blender, *script]
    environment = os.environ | {"ISIMP_SITE": site()}
    if scenario not in OF_PICTURES and "ISIMP_WINDOW_OUT" not in os.environ:
        environment["ISIMP_WINDOW_QUICK"] = "1"
    with (OUT / f"{scenario}.log").open("w+") as log:
        process = subprocess.Popen(command, env=environment, stdout=log, stderr=log, start_new_session=True)
        try:
            code = process.wait(LIMIT)
        finally:
            with suppress(ProcessLookupError):  # the X server too, in all cases
                os.killpg(process.pid, signal.SIGKILL)
        log.seek(0)
        said = log.read()
        assert code == 0, said[-4000:]
        assert "Traceback" not in said, said[-4000:]  # a timer's traceback is reported nowhere else
