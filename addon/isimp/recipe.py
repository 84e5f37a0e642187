"""Loads the folder `recipe` of the engine's package without the engine. The packed add-on has a copy of the folder."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from isimp_engine.recipe import *  # noqa: F403
else:
    _FOLDER = Path(__file__).parents[2] / "python" / "isimp_engine" / "recipe"
    _SPEC = spec_from_file_location(__name__, _FOLDER / "__init__.py")
    sys.modules[__name__] = module_from_spec(_SPEC)
    _SPEC.loader.exec_module(sys.modules[__name__])
