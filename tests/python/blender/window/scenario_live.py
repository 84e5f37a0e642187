"""The view while a setting changes, in both modes and with many faces, and an undo before it has come to rest."""

import bpy
from actions import make_scan, regions, same, settings, settled, shown, sketched, view

import isimp
from isimp.blender.scene import runtime
from isimp.blender.work import live


def wait_for(hand, count):
    """Waits until `count` regions are drawn."""
    for _ in range(400):
        if shown() == count:
            yield 0.3
            return
        yield 0.05
    raise AssertionError(f"{count} regions are not shown, but {shown()}")


def run(hand):
    isimp.register()
    make_scan(6)  # more faces than can be written one by one while a hand drags
    yield 0.5
    yield from hand.open_view()
    yield from view(hand)

    at_rest = live._SETTLED
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
    yield 0.3
    for mode in ("OBJECT", "EDIT"):
        if mode == "EDIT":
            yield from hand.into_view()
            yield from hand.key("TAB")
            yield 0.5
        live._SETTLED = 600.0
        settings().partition.proxies = 30
        yield from wait_for(hand, 30)
        same("not written yet", regions(), 14)
        same("drawn with its own lines", len(runtime.get().live.shown.work.borders) > 0, True)
        yield from sketched()
        yield from hand.shot(f"live-{mode.lower()}-1-drawn")
        settings().partition.proxies = 22
        yield from wait_for(hand, 22)
        yield from hand.undo()
        same("undone before it came to rest", (regions(), settings().partition.proxies), (14, 14))
        same("nothing is drawn any more", runtime.get().live.shown, None)
        yield from hand.redo()
        same("redone", (regions(), settings().partition.proxies), (22, 22))
        yield from hand.undo()
        same("undone again", (regions(), settings().partition.proxies), (14, 14))

        settings().partition.proxies = 30
        yield from wait_for(hand, 30)
        settings().partition.proxies = 14
        for _ in range(200):
            yield 0.05
            if runtime.get().live.shown is None:
                break
        same("back where it was", (runtime.get().live.shown, regions()), (None, 14))

        live._SETTLED = at_rest
        settings().partition.proxies = 30
        yield from settled()
        same("written", regions(), 30)
        yield from sketched()
        yield from hand.shot(f"live-{mode.lower()}-2-written")
        yield from hand.undo()
        same("one step to undo", regions(), 14)
