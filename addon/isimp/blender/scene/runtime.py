"""The state of the add-on while it is switched on: made by `start`, dropped by `stop`."""

import time
from collections import OrderedDict
from contextlib import contextmanager

from ...session import Session
from ...spare import Spare


class Live:
    """Changed settings in the panel, and their preview until they are written; see live.py."""

    def __init__(self):
        self.touched = 0.0  #: when a setting was changed last
        self.work = None  #: the Work that computes the result
        self.shown = None  #: a Preview that has no undo step yet; see preview.py
        self.tried = None  #: a Preview of a tool's result, while the mouse is held
        self.held = False  #: whether the preview must stay: the mouse is held, or it is being written
        self.wake = None  #: called when a setting was changed; None where there are no timers
        self.pending = False  #: whether a setting was changed that is no step to undo yet
        self.scan = ""  #: whose settings the panel shows
        self.settings = {}  #: object's name -> steps with the settings chosen for it, before it has regions
        self._quiet = False

    def touch(self) -> None:
        if self.wake is not None and not self._quiet:
            self.touched, self.pending = time.monotonic(), True
            self.wake()

    def shown_of(self, scan):
        """The Preview of a scan, if there is one that shows anything."""
        shown = self.shown if self.tried is None else self.tried
        return shown if shown is not None and shown.name == scan.name and shown.work.task.error is None else None

    @contextmanager
    def quiet(self):
        """Settings changed meanwhile are changed by the add-on, not by its user."""
        before, self._quiet = self._quiet, True
        try:
            yield
        finally:
            self._quiet = before


class Runtime:
    def __init__(self):
        self.session = Session()
        self.spare = Spare()
        self.running = None  #: the modal operator's Work while there is one
        self.nodes = {}  #: nodes that undo may have removed from the mesh; see store.py
        self.recipes = {}  #: (mesh's name, state) -> Recipe as it was read, None if it can't be
        self.stored = {}  #: (mesh's name, state) -> stored.Stored, until something can have changed it
        self.most_nodes = {}  #: mesh's name -> how many nodes it may have before some are forgotten; see store.py
        self.live = Live()
        self.sizes = {}  #: object's name -> (shape, size); see measure.py
        self.scans = {}  #: object's name -> the arrays read last; see reading.py
        self.former = None  #: the arrays that `scans` had before, as the next ones may be equal
        self.groups = {}  #: (object's name, vertex group's) -> weights.Group, as far as it is read
        self.late = None  #: late.Written: the last written colours in Object Mode, and the colours that Blender shows
        self.written = {}  #: object's name -> (state, regions, colours) as last written on it in Edit Mode
        self.seen = {}  #: object's name -> (state, regions) as read in Edit Mode since anything was changed
        self.edit = None  #: the BMesh in Edit Mode, kept; see mesh_io.edit_mesh
        self.own_writes = set()  #: names of meshes whose next change is the add-on's own
        self.drawings = OrderedDict()  #: overlays of scans; see overlay.py
        self.shaders = {}  #: own ones, by name
        self.pictures = None  #: of the presets, as Blender's previews
        self.keys = []  #: (key map, item) of the add-on's own shortcuts
        self.start = None  #: the draw handler of the quick start
        self.handles = ()  #: of the draw handlers
        self.report = ("", {})  #: (object's name, numbers of the polygons that were drawn over it last)
        self.sketching = None  #: (key, Task) of the next overlay
        self.comparison = None  #: what is compared in the viewports; see comparison.py
        self.status = ""  #: a tool's text in the status bar
        self.hover = None  #: the highlight under the mouse; see tools/under.py
        self.pointed = None  #: (object's name, faces) that were clicked last; see pointed.py
        self.marked = ((), ())  #: (object's name, state, faces) and the lines round the regions of these faces
        self.openings = None  #: ((object's name, state), openings) of the scan pointed at; see tools/opening.py
        self.ground = None  #: the scan pointed at
        self.surface = None  #: (Scan, pick.Surface) of the scan pointed at
        self.digging = None  #: (Scan, Task) that makes it

    def stop_sketching(self) -> None:
        """Stops the computation of an overlay; the next redraw requests it again."""
        if self.sketching is not None:
            task = self.sketching[1]
            self.sketching = None
            task.watch.cancel()
            task.wait()


_current = None


def start() -> None:
    global _current  # noqa: PLW0603  (the one piece of state the add-on has outside the file)
    _current = Runtime()


def stop() -> None:
    global _current  # noqa: PLW0603
    if _current is not None:
        for work in (_current.running, _current.live.work):
            if work is not None:
                work.abandon()
        _current.stop_sketching()
    _current = None


def get() -> Runtime:
    return _current
