"""The scan that an operator works on, looked up once when its button or the mouse is pressed."""

from functools import cached_property

from ..scene import targets
from . import panel_changes


class Target:
    """A scan and its recipe, or why there is none. Valid for one run of an operator, since undo replaces objects."""

    def __init__(self, context):
        self._context = context
        self.scan, self.problem = targets.find(context)

    @cached_property
    def recipe(self):
        """The stored recipe with the changes of the panel that have not been applied."""
        return panel_changes.recipe_of(self._context, self.scan)
