"""The recipe's rows and the live settings, with the real buttons, undo and redo."""

import bpy
from scenario_main import make_scan, regions, same, scan, show_steps
from scenario_tools import steps

import isimp


def settings():
    return bpy.context.window_manager.isimp


def settled():
    from isimp.blender.scene import runtime

    live = runtime.get().live
    for _ in range(200):
        if not live.pending and live.work is None and live.shown is None:
            yield 0.2
            return
        yield 0.05
    raise AssertionError("the settings do not settle")


def shown():
    """The number of visible regions: of the preview over the scan while a setting is dragged, else of the scan."""
    from isimp.blender.scene import runtime

    drawn = runtime.get().live.shown_of(scan())
    return regions() if drawn is None else drawn.work.task.result.numbers["regions"]


def drag(hand, name, pixels, check=None):
    """Drags over a number field as its user does."""
    yield from hand.find(name)
    x, y = hand.at
    hand.event("LEFTMOUSE", "PRESS")
    yield
    seen = set()
    for step in range(1, 25):
        hand.at = (x + pixels * step / 24, y)
        hand.event("MOUSEMOVE", "NOTHING")
        yield 0.06
        seen.add(shown())
    hand.event("LEFTMOUSE", "RELEASE")
    yield from settled()
    return seen


def run(hand):
    show_steps()
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    bpy.context.window_manager.isimp.partition.count_by = "proxies"
    yield from hand.type_into("partition.proxies", "14")
    same("nothing before Partition", regions(), 0)
    yield from hand.press("isimp.partition")
    same("regions", regions(), 14)

    yield from hand.type_into("partition.proxies", "30")
    yield from settled()
    same("typed", regions(), 30)
    yield from hand.undo()
    same("one step to undo", (regions(), settings().partition.proxies), (14, 14))
    yield from hand.redo()
    same("redone", (regions(), settings().partition.proxies), (30, 30))
    yield from hand.undo()

    seen = yield from drag(hand, "partition.proxies", 60)
    last = regions()
    print("seen while dragged:", sorted(seen), flush=True)
    assert len(seen) > 2, "nothing was shown while dragged"
    same("dragged", regions(), settings().partition.proxies)
    assert last > 14
    yield from hand.shot("steps-1-dragged")
    values = [last]
    while values[-1] != 14:  # one step to undo, and one more for each place where a slow machine made the mouse rest
        assert len(values) < 8, values
        yield from hand.undo()
        values.append(settings().partition.proxies)
        same("undone", regions(), values[-1])
    for value in reversed(values[:-1]):
        yield from hand.redo()
        same("redone", (regions(), settings().partition.proxies), (value, value))
    for _ in values[1:]:
        yield from hand.undo()

    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=100)
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=5000)
    same("two added", regions(), 16)
    yield from hand.type_into("partition.proxies", "20")
    yield from settled()
    same("what follows is done again", (regions(), len(steps())), (22, 3))
    yield from hand.undo()
    same("and undone", (regions(), len(steps())), (16, 3))

    yield from hand.press("isimp.step_open")
    yield from hand.shot("steps-2-open")
    index = settings().open_step
    same("open", 0 <= index <= 2, True)
    bpy.ops.isimp.step_open(step=index)
    bpy.ops.isimp.step_open(step=2)
    yield 0.3
    bpy.ops.isimp.step_delete("INVOKE_DEFAULT", True, step=2)
    yield from hand.settle()
    same("deleted", (regions(), len(steps())), (15, 2))
    yield from hand.undo()
    same("not deleted", (regions(), len(steps())), (16, 3))
    bpy.ops.isimp.step_open(step=1)
    bpy.ops.isimp.step_open(step=0)
    yield 0.3
    bpy.ops.isimp.step_switch("INVOKE_DEFAULT", step=0)
    yield from hand.settle()
    yield from hand.shot("steps-3-failed")
    yield from hand.undo()
