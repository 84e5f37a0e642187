"""Houses whose planes are known: triangle meshes with walls, windows, a gable roof and a bay, with noise on request."""

from dataclasses import dataclass

import numpy as np

EAVE, RIDGE = 30, 4  # in cells
ROW, APART, ACROSS = 5, 19.0, 24.0  # houses at each side of a street, and metres between their corners


@dataclass(frozen=True)
class House:
    """A triangle mesh and the true plane of each face (`label`), by number; `clean` are its vertices without noise."""

    vertices: np.ndarray
    triangles: np.ndarray
    label: np.ndarray
    clean: np.ndarray

    @property
    def diagonal(self) -> float:
        """The diagonal of the bounding box of the house without noise."""
        return float(np.linalg.norm(np.ptp(self.clean, axis=0)))


def _cells(rng: np.random.Generator) -> np.ndarray:
    """The inner cells of a grid: a block with a bay, rows of windows and a door, drawn by `rng`.

    Its depth is even, so that the ridge runs between two cells and the roof is planar.
    """
    nx, ny = int(rng.integers(52, 64)), 2 * int(rng.integers(18, 22))
    cells = np.zeros((nx, ny, EAVE + RIDGE + 10), bool)
    cells[2:-2, 2:-2, : EAVE + RIDGE] = True
    cells[nx - 20 : nx - 4, 0:14, : int(rng.integers(12, 16))] = True
    wide, low, high = int(rng.integers(3, 5)), int(rng.integers(4, 6)), int(rng.integers(17, 19))
    for x in range(6, nx - 22, 8):
        for z in (low, high):
            cells[x : x + wide, 2:4, z : z + 7] = False
            cells[x : x + wide, -4:-2, z : z + 7] = False
    for y in range(8, ny - 6, 8):
        cells[2:4, y : y + wide, high : high + 7] = False
    cells[24:29, -4:-2, 0:12] = False
    return cells


def _sides(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[tuple[int, ...]]]:
    """The squares between inside and outside: grid points, four corners each, and the plane of each as a key."""
    corners, keys = [], []
    points: dict[tuple[int, ...], int] = {}
    for axis in range(3):
        for side in (0, 1):
            beyond = np.roll(cells, -1 if side else 1, axis)
            edge = [slice(None)] * 3
            edge[axis] = slice(-1, None) if side else slice(0, 1)
            beyond[tuple(edge)] = False
            for cell in np.argwhere(cells & ~beyond):
                low = cell.copy()
                low[axis] += side
                a, b = [(1, 2), (2, 0), (0, 1)][axis]
                square = [low.copy() for _ in range(4)]
                square[1][a] += 1
                square[2][[a, b]] += 1
                square[3][b] += 1
                at = [points.setdefault(tuple(map(int, p)), len(points)) for p in square]
                corners.append(at if side else at[::-1])
                roof = axis == 2 and side and low[2] == EAVE + RIDGE
                keys.append((axis, side, int(low[axis]), int(roof and cell[1] >= cells.shape[1] // 2)))
    return np.array(list(points), float), np.array(corners), keys


def make(noise: float = 0.0, seed: int = 1, turn: float = 17.0, at: tuple[float, float, float] = (0, 0, 0)) -> House:
    """A house of about 15 by 10 by 9 metres.

    noise: standard deviation of each vertex's displacement, as a share of the diagonal; turn: degrees about the upright
    axis; at: its place. The same arguments give the same house.
    """
    rng = np.random.default_rng(seed)
    cells = _cells(rng)
    points, corners, keys = _sides(cells)
    middle = cells.shape[1] / 2
    lift = 0.55 * (middle - 2 - np.abs(points[:, 1] - middle))
    above = points[:, 2] > EAVE
    points[above, 2] += (points[above, 2] - EAVE) / RIDGE * lift[above]
    number = {key: i for i, key in enumerate(dict.fromkeys(keys))}
    angle = np.deg2rad(turn)
    cos, sin = np.cos(angle), np.sin(angle)
    clean = 0.25 * points @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    length = np.linalg.norm(np.ptp(clean, axis=0))
    moved = clean + rng.normal(size=clean.shape) * noise * length / np.sqrt(3)
    triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).astype(np.int32)
    label = np.repeat([number[key] for key in keys], 2)
    return House(moved + np.asarray(at, float), triangles, label, clean + np.asarray(at, float))


def street(count: int = 10, noise: float = 0.001) -> House:
    """Houses at both sides of a street, each with noise of its own and turned a little."""
    made, labels, points = [], 0, 0
    for number in range(count):
        place = (APART * (number % ROW), ACROSS * (number // ROW), 0.0)
        house = make(noise, number + 1, turn=3.0 * (number % ROW) - 6.0, at=place)
        made.append(House(house.vertices, house.triangles + points, house.label + labels, house.clean))
        points += len(house.vertices)
        labels += int(house.label.max()) + 1
    return House(
        np.concatenate([h.vertices for h in made]),
        np.concatenate([h.triangles for h in made]),
        np.concatenate([h.label for h in made]),
        np.concatenate([h.clean for h in made]),
    )
