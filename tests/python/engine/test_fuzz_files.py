"""Damaged files of all kinds that are read in Python: each is read, or refused in one line that names it.

ISIMP_FUZZ_FILES is the number of cases of each family (150). A case is made from its number, so a failure comes again.
"""

import os
import random
import signal

import numpy as np
import pytest

import hostile
import isimp_engine as engine
from isimp_engine import batch, recipes
from isimp_engine.batch import page
from isimp_engine.batch.run import Outcome
from isimp_engine.cli import batch as command
from isimp_engine.texturing.images import decode
from isimp_engine.tiles import tileset

CASES = int(os.environ.get("ISIMP_FUZZ_FILES", "150"))
_SECONDS = 60  # that a case may take before it counts as one without an end


def read_textured(path):
    soup = engine.read_textured(path)
    assert soup.triangles.min(initial=0) >= 0
    assert soup.triangles.max(initial=-1) < len(soup.vertices)
    assert np.isfinite(soup.uv).all()
    assert all(image is None or image.dtype in (np.uint8, np.uint16) for image in soup.images)


def read_tileset(path):
    for leaf in tileset.leaves(path):
        vertices, triangles = tileset.read(leaf)
        assert triangles.max(initial=-1) < len(vertices)


def read_rows(folder):
    (folder / ".isimp-batch").mkdir(exist_ok=True)
    found = batch.table.read_rows(folder)
    page.write(folder, found, folder)
    outcome = Outcome(found, len(found), 0, cut_short=False)
    os.fsencode("\n".join(command.summary(outcome, folder, False)))


FAMILIES = {
    "gltf": (hostile.gltf, read_textured),
    "tileset": (hostile.tileset, read_tileset),
    "rows": (hostile.rows, read_rows),
    "image": (hostile.image, lambda path: decode(path, str(path))),
    "obj": (hostile.obj, read_textured),
    "ply": (hostile.ply, read_textured),
    "recipe": (hostile.recipe, recipes.read),
}


@pytest.mark.parametrize("family", FAMILIES)
def test_damaged_files_are_read_or_refused_in_a_line(tmp_path, family):
    make, read = FAMILIES[family]
    refused = 0
    for number in range(CASES):
        made = make(tmp_path, random.Random(f"{family} {number}"))
        if hasattr(signal, "alarm"):
            signal.alarm(_SECONDS)
        try:
            read(made)
        except (engine.FileError, recipes.RecipeError) as error:
            refused += 1
            said = str(error)
            assert said.startswith(str(tmp_path)), (family, number)
            assert not {"\n", "\r"} & set(said), (family, number)  # names may contain other separators
        except BaseException:
            print(f"{family}, case {number}")  # before the traceback
            raise
        finally:
            if hasattr(signal, "alarm"):
                signal.alarm(0)
    assert refused < CASES
    assert refused > 0.1 * CASES or family == "rows"
