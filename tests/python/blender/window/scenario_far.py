"""The drawing over a scan whose data lie far from zero, compared with the same scan near zero."""

import bpy
import numpy as np
import scans
from scenario_main import same, scan
from scenario_tools import view

import isimp

FAR = np.array([2.0**20, -(2.0**20), 0.0])


def make_scan(shift):
    bpy.data.batch_remove(list(bpy.data.objects))
    scan = scans.cube(cells=16)
    points = 32 * scans.coordinates(scan.data) + shift
    scan.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    scan.data.update()
    scan.location = -shift
    return scan


def run(hand):
    isimp.register()
    yield 0.5
    yield from hand.open_tab()

    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    for name, shift in (("near", 0 * FAR), ("far", FAR)):
        make_scan(shift)
        yield 0.3
        yield from view(hand)
        bpy.context.window_manager.isimp.outline = True
        bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
        yield 0.3
        for _ in range(200):  # the colours of the scan before are there already
            if overlay._key(bpy.context, scan()) in runtime.get().drawings:
                break
            yield 0.05
        sketch = runtime.get().drawings[overlay._key(bpy.context, scan())].sketch
        same("place of what is drawn", np.abs(np.asarray(sketch.origin) - shift).max() < 100, True)
        same("corners", len(sketch.corners), 8)
        same("each within reach of it", np.abs(sketch.corners).max() < 100, True)
        yield from hand.shot(f"far-1-{name}")
        bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
        yield 0.3
        yield from hand.shot(f"far-2-{name}-mesh")
