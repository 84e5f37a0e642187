"""Runs pytest inside Blender: `blender -b --factory-startup --python-exit-code 1 --python inside.py -- ARGUMENTS`.

Blender ignores PYTHONPATH: ISIMP_SITE names the folders with pytest and the engine in its place.
"""

import os
import sys

sys.path[:0] = [folder for folder in os.environ.get("ISIMP_SITE", "").split(os.pathsep) if folder]

import pytest  # noqa: E402  (it is found in the folders above)

sys.exit(pytest.main(sys.argv[sys.argv.index("--") + 1 :]))
