"""A real window of Debian's Blender under Xvfb, driven by simulated mouse and keys; pictures are kept in out/window."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[3]
OUT = ROOT / "out" / "window"


def site():
    """Where a Blender finds the add-on and what this Python has installed."""
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
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", "1200", "760"]
    script = ["--python", str(HERE / "drive.py"), "--", str(HERE / f"scenario_{scenario}.py"), str(OUT)]
    command = ["xvfb-run", "-a", "-s", "-screen 0 1200x760x24", *blender, *script]
    done = subprocess.run(command, env=os.environ | {"ISIMP_SITE": site()}, capture_output=True, text=True, timeout=300)
    print(done.stdout, done.stderr)
    assert done.returncode == 0, done.stderr[-3000:]
