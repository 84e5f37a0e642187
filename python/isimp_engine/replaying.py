"""Does the steps of a recipe on a scan, with the options of a caller."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from typing import Any

from . import recipe as rcp
from ._core import InvalidInput, Job
from .guided import Guides
from .jobs import Steps
from .marks import Marks, guides_of
from .repairs import Meshes, Repair, Repaired
from .replay import edited, placed
from .settings import OptionError, Settings
from .source import Source
from .states import Split, State, partitioned, split_of


class Replay:
    """Makes the partition of a scan, and does the steps of a recipe."""

    def __init__(self, source: Source, settings: Settings, steps: Steps, marks: Marks, meshes: Meshes) -> None:
        self._source, self._settings, self._steps, self._marks, self._meshes = source, settings, steps, marks, meshes
        self.clicks: dict[str, Any] | None = None  #: how faces of a recipe were found; None without any

    def replayed(self, recipe: rcp.Recipe) -> State:
        """Do the steps of a recipe, with its faces at their places in this scan."""
        named, by_number = recipe.faces(), recipe.places is None
        recipe, lost = placed(recipe, self._source.surface)
        if named:
            self.clicks = {"by": "number" if by_number else "place", "lost": []}
        for index in lost:
            self._lose(index, recipe.steps[index], "no face of this scan is near its place and faces its way")
        whole, _ = recipe.whole()
        others: tuple[type[rcp.Step], ...] = (rcp.Mesh, rcp.Texture)
        if self._settings.regularise is not None:
            others = (*others, rcp.Regularise)
        # The last partition of all faces replaces all regions except locked ones.
        first = 0 if recipe.locks_before(whole) else whole
        state = None
        for index, step in recipe.active():
            if index < first or isinstance(step, others):
                continue
            try:
                state = self._done(step, index == whole, state)
            except OptionError as error:
                if index == whole:
                    raise
                if state is None or not rcp.faces_of(step):
                    raise OptionError(f"step {index + 1}: {error}") from None
                self._lose(index, step, str(error))
        assert state is not None  # there is a partition of all faces
        return state

    def _lose(self, index: int, step: rcp.Step, why: str) -> None:
        if self._settings.strict:
            raise OptionError(f"step {index + 1}: {why}")
        assert self.clicks is not None  # the step names faces
        self.clicks["lost"].append({"step": index + 1, "kind": rcp.KINDS[type(step)], "why": why})

    def _done(self, step: rcp.Step, is_last: bool, state: State | None) -> State:
        """The state after a step. is_last: of the partition of all faces that the options belong to."""
        if isinstance(step, rcp.Partition):
            return self.partitioned(None if is_last else step, state)
        assert state is not None
        with self._steps("partition") as job, _named(state):
            part = edited(rcp.KINDS[type(step)], step, state.repaired.faces, state.partition, job)
        return replace(state, partition=part, made=None)

    def partitioned(self, step: rcp.Partition | None = None, before: State | None = None) -> State:
        """The state after a partition. step: None: by the options of the caller."""
        settings, angle = self._settings, self._settings.angle if step is None else step.angle

        def guides(repaired: Repaired, job: Job) -> Guides:
            return guides_of(self._marks, angle if angle is None or angle < 180 else None, repaired, job)

        if step is None:
            repair = Repair.by(settings.clean, settings.kept_places)
            whole = None if settings.recipe is None else settings.recipe.whole()[1]
            more = () if whole is None else whole.more
            wanted = Split(settings.partition, repair, not settings.keep_openings, guides, more=more)
        else:
            known = settings.partition
            wanted = split_of(step, guides, settings.clean, threads=known.threads, backend=known.backend)
        with nullcontext() if before is None else _named(before):
            return partitioned(wanted, self._source, self._meshes, self._steps, before)


@contextmanager
def _named(state: State) -> Iterator[None]:
    """An error becomes one of the options, with the numbers of the scan's faces."""
    try:
        yield
    except InvalidInput as error:
        raise OptionError(state.repaired.faces.named(str(error))) from None
    except ValueError as error:  # it names faces of the scan
        raise OptionError(str(error)) from None
