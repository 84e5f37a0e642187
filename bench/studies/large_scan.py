"""The work on a large scan before its polygons are made: ways compared in one run, as ratios of processor time.

    python -m bench.studies.large_scan SCAN [DETAIL]

Rows: repair and partition by a detail, with the openings closed before the regions are counted or after (the same
regions, where the guess is right); pairs of triangles that share an edge, by the engine or by sorting in numpy.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import isimp_engine as engine
from isimp_engine.openings import closed_for, lengths_for

Arrays = tuple[np.ndarray, np.ndarray]
ROUNDS = 3


def closed_first(scan: Arrays, options: engine.PartitionOptions) -> tuple[engine.Partition, str]:
    """The partition, and whether the guess was right."""

    def count() -> int:
        return engine.partition(plain, options).region_count

    plain = engine.clean(*scan)
    lengths = lengths_for(plain, options, None, count)
    found = engine.partition(lengths.closed(plain), options)
    if lengths.hold_for(found.region_count):
        return found, "counted" if lengths.most is None else "guessed right"
    lengths = lengths_for(plain, options, found.region_count, count)
    return engine.partition(lengths.closed(plain), options), "guessed wrong"


def counted_first(scan: Arrays, options: engine.PartitionOptions) -> engine.Partition:
    plain = engine.clean(*scan)
    regions = engine.partition(plain, options).region_count
    return engine.partition(closed_for(plain, regions), options)


def sorted_pairs(triangles: np.ndarray) -> np.ndarray:
    """As `guides.shared_edges`, for a manifold."""
    start = triangles.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    key = (np.minimum(start, end) << 32 | np.maximum(start, end)).ravel()
    order = np.argsort(key, kind="stable")
    at = np.flatnonzero(key[order][:-1] == key[order][1:])
    return np.stack([order[at], order[at + 1]]).T // 3


def seconds(call: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    found = call()
    return time.process_time() - start, found


def compare(name: str, new: Callable[[], Any], old: Callable[[], Any], same: Callable[[Any, Any], str]) -> None:
    ratios, note = [], ""
    for _ in range(ROUNDS):
        before, expected = seconds(old)
        after, found = seconds(new)
        ratios.append(after / before)
        note = same(found, expected)
    print(f"{name:34} {sorted(ratios)[ROUNDS // 2]:5.2f} x ({after:.2f} s of {before:.2f} s), {note}")


def main() -> None:
    scan = engine.read(sys.argv[1])
    options = engine.PartitionOptions(detail=float(sys.argv[2])) if len(sys.argv) > 2 else engine.PartitionOptions()
    compare(
        "closed first / counted first",
        lambda: closed_first(scan, options),
        lambda: counted_first(scan, options),
        lambda a, b: f"{a[1]}, labels equal: {np.array_equal(a[0].face_region, b.face_region)}",
    )
    triangles = np.asarray(engine.clean(*scan).triangles)
    compare(
        "shared edges, engine / numpy",
        lambda: engine.guides.shared_edges(triangles)[0],
        lambda: sorted_pairs(triangles),
        lambda a, b: f"pairs equal: {np.array_equal(a, b)}",
    )


if __name__ == "__main__":
    main()
