"""The reverberation time of a scanned room, by pyroomacoustics.

    python acoustics.py SCAN [--absorption 0.1] [--source X Y Z]

SCAN is the inside of a room in metres. The package pyroomacoustics takes planar, convex walls, which `planar` and
`convex` make; it follows rays between them. Without --source, source and microphone are near the middle of the room.
"""

import argparse

import numpy as np
import pyroomacoustics as pra

import isimp_engine as engine

RATE = 16_000  # samples a second


def room_of(path: str, absorption: float) -> pra.Room:
    """The walls of a scan, each with the same absorption."""
    polygons = engine.simplify(path, planar=True, convex=True).polygons
    corners = [polygons.vertices[face] for face in polygons.faces()]
    walls = [pra.wall_factory(each[::-1].T, [absorption], [0.1]) for each in corners]  # their normals face outwards
    return pra.Room(walls, fs=RATE, max_order=3, ray_tracing=True, air_absorption=True)


def main() -> None:
    command = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("scan")
    command.add_argument("--absorption", type=float, default=0.1)
    command.add_argument("--source", type=float, nargs=3)
    asked = command.parse_args()
    room = room_of(asked.scan, asked.absorption)
    middle = np.mean([wall.corners.mean(axis=1) for wall in room.walls], axis=0)
    room.add_source(asked.source or middle + 0.4)
    room.add_microphone(middle - 0.4)
    room.compute_rir()
    print(f"{len(room.walls)} walls, reverberation time {room.measure_rt60()[0, 0]:.2f} s")


if __name__ == "__main__":
    main()
