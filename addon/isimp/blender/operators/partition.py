import bpy

from ... import recipe as rcp
from .. import settings
from ..modal import RecipeOperator
from ..show import show_regions


class ISIMP_OT_partition(RecipeOperator, settings.PartitionSettings, bpy.types.Operator):
    """Split the scan into near-planar regions, shown in colours. The scan itself is not changed"""

    bl_idname = "isimp.partition"
    bl_label = "Partition"

    def wanted(self, context, scan):
        return rcp.Recipe().then(settings.to_step(rcp.Partition, self))

    show = staticmethod(show_regions)

    def told(self, before, numbers):
        more = numbers["regions"] - numbers["asked"]
        needs = f", {more} more than asked, as its parts need them" if more > 0 else ""
        return f"{numbers['triangles']:,} triangles in {numbers['regions']} regions{needs}"


CLASSES = (ISIMP_OT_partition,)
