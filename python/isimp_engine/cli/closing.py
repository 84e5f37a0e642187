"""Close what scanning left open: holes and tunnels that are smaller than what the regions can show."""

import argparse

from .. import CleanOptions, Job, Mesh, PartitionOptions, opening_length, partition


def is_wanted(arguments: argparse.Namespace) -> bool:
    """Not where the user has said what to close, nor with a bound: that promises each vertex of the scan."""
    kept = arguments.keep_openings or (arguments.recipe is not None and not arguments.recipe.close_openings)
    given = arguments.clean.fill_holes > 0 or arguments.clean.cut_handles > 0
    return not (kept or given or arguments.options.bound)


def closing_options(mesh: Mesh, options: PartitionOptions, clean: CleanOptions, job: Job) -> CleanOptions | None:
    """How to repair the scan once more, so that its small openings are closed; None where it has none.

    Where the number of regions is to be found, it is found on the scan as it is.
    """
    regions = options.proxies
    if not regions:  # to be found; 0 is refused by the partition
        if opening_length(mesh, 1, job) == 0:
            return None
        regions = partition(mesh, options, job).region_count
    length = opening_length(mesh, regions, job)
    if length == 0:
        return None
    return CleanOptions(**clean.as_dict() | {"fill_holes": length, "cut_handles": length})
