"""The folder with the intermediate results of a run, and the plan that they belong to."""

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .. import FileError, __version__
from ..batch.table import sync_folder
from ..folders import Own
from .errors import TileFailed
from .plan import Plan
from .store import DAMAGED
from .tasks import FOLDERS

PLAN = "plan.json"
NAMES = rf"plan\.json(\.part)?|parts|running-\w+|{FOLDERS}"  #: names in a work folder


def begin(plan: Plan, own: Own) -> int:
    """Prepare the work folder; returns the number of steps of tiles that an earlier run of the same plan did."""
    note, key = plan.work / PLAN, plan.key()
    if key_of(plan.work) == key:
        return sum(1 for _ in plan.work.glob("*/*/values.json"))
    own.clear(PLAN)
    part = plan.work / f"{PLAN}.part"
    with part.open("w", encoding="utf-8") as file:
        json.dump({"key": key, "isimp": __version__}, file)
        file.flush()
        os.fsync(file.fileno())
    part.replace(note)
    sync_folder(plan.work)
    return 0


@contextmanager
def damage_forgotten(work: Path) -> Iterator[None]:
    """Remove the plan if a file of the work folder is damaged, so that the next run begins with an empty folder."""
    try:
        yield
    except (FileError, TileFailed) as error:
        if DAMAGED in str(error):
            (work / PLAN).unlink(missing_ok=True)
        raise TileFailed(str(error)) from None


def key_of(work: Path) -> str | None:
    """Return the key of the plan of a work folder; None if it has no readable plan."""
    try:
        said = json.loads((work / PLAN).read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    key = said.get("key") if isinstance(said, dict) and "isimp" in said else None
    return key if isinstance(key, str) and re.fullmatch("[0-9a-f]{64}", key) else None
