"""Installs the package that STEP files need. Only the legacy zip has this file: extensions may not start programs."""

import importlib
import os
import subprocess
import sys
import tempfile
from importlib import util
from pathlib import Path

import bpy

from ... import handover
from ...engine import engine
from ...language import said
from ..scene import places
from ..view import overlay

_TICK = 0.2
_STEP = Path("solid.step")


class ISIMP_OT_install_step(bpy.types.Operator):
    """Download the package for STEP files, about 100 MB, with Blender's own Python into Blender's modules"""

    bl_idname = "isimp.install_step"
    bl_label = "Install for Blender"

    @classmethod
    def poll(cls, context):
        return engine is not None and bool(engine.exporting.missing(_STEP))

    def invoke(self, context, event):
        self._begin()
        if bpy.app.background:
            return self.execute(context)
        overlay.tell(context, said("Installing {package} · Esc: cancel", package=engine.exporting.missing(_STEP)))
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.cancel(context)
            return {"CANCELLED"}
        if event.type != "TIMER" or self._running.poll() is None or self._starts_next():
            return {"PASS_THROUGH"}
        self._leave(context)
        return self._end()

    def execute(self, context):
        if not hasattr(self, "_running"):
            self._begin()
        self._running.wait()
        while self._starts_next():
            self._running.wait()
        return self._end()

    def cancel(self, context):
        """Ends pip. Blender calls this if the window or the file is closed."""
        self._running.kill()
        self._leave(context)

    def _begin(self) -> None:
        command = handover.pip(places.modules(), engine.exporting.missing(_STEP))
        self._commands = [command]
        if util.find_spec("pip") is None:
            self._commands.insert(0, [command[0], "-m", "ensurepip"])
        # Programs that pip starts may write another encoding than UTF-8.
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115  (until pip has ended)
        self._starts_next()

    def _starts_next(self) -> bool:
        """Start the next command. Return whether there was one."""
        if not self._commands:
            return False
        environment = os.environ | {"PYTHONIOENCODING": "utf-8"}
        command = self._commands.pop(0)
        self._running = subprocess.Popen(command, env=environment, stdout=self._log, stderr=subprocess.STDOUT)
        return True

    def _leave(self, context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        overlay.tell(context, "")

    def _end(self):
        self._log.seek(0)
        lines = [line.strip() for line in self._log if line.strip()]
        self._log.close()
        if self._running.returncode:
            why = next((line for line in lines if line.startswith("ERROR")), lines[-1] if lines else "")
            self.report({"ERROR"}, said("Nothing was installed: {reason}", reason=why))
            return {"CANCELLED"}
        folder = str(places.modules())
        if folder not in sys.path:  # Blender adds it when it starts
            sys.path.append(folder)
        importlib.invalidate_caches()
        self.report({"INFO"}, said("Installed into {folder}", folder=folder))
        return {"FINISHED"}


CLASSES = (ISIMP_OT_install_step,)
