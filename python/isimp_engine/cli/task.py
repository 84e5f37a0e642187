"""One run of `isimp simplify` as typed values, made once from the command line and the recipe."""

from dataclasses import dataclass, field
from pathlib import Path

from ..settings import Settings
from .guiding import GuideFiles


@dataclass(frozen=True)
class Simplification:
    """The files of a run, and how the scan is simplified."""

    input: Path
    output: Path
    settings: Settings
    guides: GuideFiles = field(default_factory=GuideFiles)
    labels: Path | str | None = None  #: STDOUT is refused
    report: Path | str | None = None
    lods: list[int] | None = None  #: number of regions of each level
    quiet: bool = False
