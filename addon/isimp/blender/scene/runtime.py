"""The state of the add-on while it is enabled: created by `start`, dropped by `stop`."""

import time
from collections import OrderedDict
from contextlib import contextmanager

from ...array_pool import ArrayPool
from ...engine import is_replaced
from ...session import Session


class Live:
    """Changed settings of the panel, and their preview until they are written; see live.py."""

    def __init__(self):
        self.touched = 0.0  #: time of the last change of a setting
        self.work = None  #: the Work that computes the result
        self.shown = None  #: a Preview that has no undo step yet; see preview.py
        self.tried = None  #: a Preview of a tool's result, while the mouse is held
        self.held = False  #: whether the preview must stay: the mouse is held, or it is being written
        self.wake = None  #: called after a change of a setting; None in the background, which has no timers
        self.pending = False  #: whether a changed setting has no undo step yet
        self.scan = ""  #: name of the scan whose settings the panel shows
        self.settings = {}  #: object's name -> steps with its settings, chosen before it has regions
        self._quiet = False

    def touch(self) -> None:
        if self.wake is not None and not self._quiet:
            self.touched, self.pending = time.monotonic(), True
            self.wake()

    def shown_of(self, scan):
        """Return the Preview of a scan; None if there is none, or its work failed."""
        shown = self.shown if self.tried is None else self.tried
        return shown if shown is not None and shown.name == scan.name and shown.work.task.error is None else None

    @contextmanager
    def quiet(self):
        """Ignores changes of settings inside the context: the add-on makes them, not the user."""
        before, self._quiet = self._quiet, True
        try:
            yield
        finally:
            self._quiet = before


class Runtime:
    def __init__(self):
        self.session = Session()
        self.is_replaced = is_replaced()  #: whether another version was installed over the running one
        self.pool = ArrayPool()
        self.running = None  #: the Work of the running modal operator
        self.nodes = {}  #: nodes that undo may have removed from the mesh; see store.py
        self.recipes = {}  #: (mesh's name, state) -> Recipe, None if it can't be read
        self.stored = {}  #: (mesh's name, state) -> stored.Stored, until it may have changed
        self.most_nodes = {}  #: mesh's name -> number of nodes above which unused ones are dropped; see store.py
        self.live = Live()
        self.sizes = {}  #: object's name -> (shape, size); see measure.py
        self.scans = {}  #: object's name -> the arrays read last; see reading.py
        self.former = None  #: the previous arrays of `scans`, reused if the next ones are equal
        self.groups = {}  #: (object's name, vertex group's) -> weights.Group, possibly read in part
        self.late = None  #: late.Written: the last written colours in Object Mode, and the colours that Blender shows
        self.written = {}  #: object's name -> (state, regions, colours) as last written on it in Edit Mode
        self.seen = {}  #: object's name -> (state, regions) read in Edit Mode, dropped on changes
        self.edit = None  #: the BMesh in Edit Mode, kept; see mesh_io.edit_mesh
        self.own_writes = set()  #: names of meshes whose next change is the add-on's own
        self.drawings = OrderedDict()  #: overlays of scans; see overlay.py
        self.shaders = {}  #: the add-on's shaders by name
        self.keys = []  #: (key map, item) of the add-on's own shortcuts
        self.start = None  #: the draw handler of the quick start
        self.handles = ()  #: the draw handlers of the overlay
        self.report = ("", {})  #: (object's name, numbers of the polygons drawn over it last)
        self.sketching = None  #: (key, Task) of the next overlay
        self.comparison = None  #: the Comparison in the viewports; see comparison.py
        self.status = ""  #: a tool's text in the status bar
        self.hover = None  #: the highlight under the mouse; see tools/under.py
        self.pointed = None  #: (object's name, faces clicked last); see pointed.py
        self.marked = ((), ())  #: (object's name, state, faces) and the border lines of the regions of these faces
        self.openings = None  #: ((object's name, state), openings) of the scan under the mouse; see tools/opening.py
        self.ground = None  #: the under.Ground of the scan under the mouse
        self.surface = None  #: (Scan, pick.Surface) of the scan under the mouse
        self.digging = None  #: (Scan, Task that makes its surface)

    def stop_sketching(self) -> None:
        """Stops the computation of an overlay; the next redraw requests it again."""
        if self.sketching is not None:
            task = self.sketching[1]
            self.sketching = None
            task.watch.cancel()
            task.wait()


_current = None


def start() -> None:
    global _current  # noqa: PLW0603  (the only state of the add-on outside the file)
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
