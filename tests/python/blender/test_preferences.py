"""Preferences: the settings of a user for all files."""

import types

import bpy
import numpy as np
import scans

from isimp import session
from isimp.blender import preferences
from isimp.blender.scene import runtime, targets


def test_threads_and_back_end_reach_the_engine_and_change_no_result(monkeypatch):
    wish = type("Wish", (preferences._Default,), {"threads": 0, "backend": "cpu"})
    monkeypatch.setattr(preferences, "get", lambda context: wish)
    asked, labels = [], []

    def noted(options):
        return lambda **given: asked.append((given["threads"], given.get("backend"))) or options(**given)

    for module, name in ((session.engine.states, "PartitionOptions"), (session.engine, "MeshingOptions")):
        monkeypatch.setattr(module, name, noted(getattr(module, name)))
    for wish.threads in (0, 1, 3):
        runtime.get().session = session.Session()
        scan = scans.dimple(scans.cube(cells=8))
        bpy.ops.isimp.partition(proxies=12, method="naive")
        labels.append(scans.regions(scan))
        bpy.ops.isimp.mesh()
    assert asked == [(threads, backend) for threads in (0, 1, 3) for backend in ("cpu", None)]
    assert all(np.array_equal(labels[0], other) for other in labels[1:])


def test_a_missing_back_end_is_not_used(monkeypatch):
    wish = type("Wish", (preferences._Default,), {"backend": "cuda"})
    monkeypatch.setattr(preferences, "get", lambda context: wish)
    monkeypatch.setattr(preferences, "_BACKENDS", ("cpu",))
    scans.cube()
    assert bpy.ops.isimp.partition(proxies=6, method="queued") == {"FINISHED"}
    assert runtime.get().session.backend == "cpu"


def test_a_wrong_installation_is_told_in_the_preferences_and_in_the_panel(monkeypatch):
    class Row:
        def __init__(self):
            self.told = []

        def label(self, text, icon="NONE"):
            self.told.append(text)

        def __getattr__(self, name):
            return lambda *_, **__: Row()

    drawn = types.SimpleNamespace(show_keys=False)
    monkeypatch.setattr(runtime.get(), "is_replaced", True)
    assert targets.install_problem() == "Another version of iSimp was installed: start Blender again"
    drawn.layout = Row()
    preferences.IsimpPreferences.draw(drawn, bpy.context)
    assert targets.install_problem() in " ".join(drawn.layout.told)
    monkeypatch.setattr(runtime.get(), "is_replaced", False)
    assert targets.install_problem() == ""
    monkeypatch.setattr(session, "ENGINE_PROBLEM", "no such module")
    drawn.layout = Row()
    preferences.IsimpPreferences.draw(drawn, bpy.context)
    assert "(no such module)" in " ".join(drawn.layout.told)
