"""Merging by groups of tiles: steps of one group, and values common to all groups.

If there are many tiles, no process holds the graph of all patches. Adjacent tiles form groups. Each group merges its
patches, cheapest pair first; two patches with neighbours in other groups do not merge. All groups are cut at one price,
which follows from the prices of their merges. Then the clusters of all groups are joined.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import borders, steps
from .store import load, of_tile, save, values_of

GROUP = 4  #: largest number of tiles in a group; a scan of at most this number has no groups
_EARLY = 0.25  # merging in a group ends at this share of the nodes that a group keeps on average
_SPARE = 1.02  # nodes that groups leave, as a multiple of the target of the last merging
_WAITING = 1.0  # extra nodes for each node at a border of groups, since merges near it are late
_COARSER = 8  # with a tolerance: ratio of the least cost at the cut to the limit in groups
_GRAPH = ("sums", "pairs", "edge_patch", "fringe_edge_keys")

Task = dict[str, Any]


def groups_of(centres: NDArray[np.float64], largest: int) -> list[list[int]]:
    """Group near tiles: split them in halves along the longest side until no group has more than `largest`."""
    groups: list[list[int]] = []

    def halve(own: NDArray[np.int64]) -> None:
        if len(own) <= largest:
            groups.append(sorted(own.tolist()))
            return
        places = centres[own]
        axis = int(np.argmax(places.max(0) - places.min(0)))
        order = own[np.argsort(places[:, axis], kind="stable")]
        halve(order[: len(own) // 2])
        halve(order[len(own) // 2 :])

    halve(np.arange(len(centres)))
    return groups


def beside(low: NDArray[np.float64], high: NDArray[np.float64], group: list[int], off: float) -> list[int]:
    """Return the tiles outside a group whose boxes, from `low` to `high`, are at most `off` from a box of the group."""
    near = np.zeros(len(low), bool)
    for k in group:
        near |= ((low <= high[k] + off) & (high >= low[k] - off)).all(1)
    near[group] = False
    found: list[int] = np.flatnonzero(near).tolist()
    return found


def group(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the graph of a group of tiles, and the merges inside it."""
    tiles = task["own"]
    folders = [of_tile(work, "patches", tile) for tile in tiles]
    own = [load(folder, "fringe_edge_keys") for folder in folders]
    keys = own + [load(of_tile(work, "patches", tile), "fringe_edge_keys") for tile in task["beside"]]
    sums = [load(folder, "sums") for folder in folders]
    first = np.cumsum([0] + [len(each) for each in sums])
    patch = np.concatenate([load(f, "edge_patch") + o for f, o in zip(folders, first, strict=False)]).astype(np.int32)
    edge_tile = np.repeat(np.arange(len(keys), dtype=np.int32), [len(k) for k in keys])
    every = np.concatenate(keys)
    matched = borders.match(every, edge_tile)
    inside = matched[(matched < len(patch)).all(1)]
    outer = matched[matched[:, 0] < len(patch), 0], matched[matched[:, 1] < len(patch), 1]
    edge = np.setdiff1d(np.concatenate(outer), inside)  # their other side is in another group
    rim = np.ones(len(patch), bool)
    rim[inside] = rim[edge] = False
    inner = [load(f, "pairs") + o for f, o in zip(folders, first, strict=False)]
    pairs = np.concatenate([*inner, patch[inside]]).astype(np.int32)
    whole = np.concatenate(sums)
    border, opened = np.zeros((2, len(whole)), np.uint8)
    border[patch[edge]] = 1
    opened[patch[rim]] = 1
    lengths = np.zeros(len(pairs))  # borders cost nothing yet
    found = steps.find_components(whole, pairs, lengths, opened, len(whole), 0.0)
    target = int(_EARLY * task["share"] * len(whole))
    merges = steps.merge_inside(
        whole, pairs, lengths, found, border, target, math.inf if task["limit"] is None else task["limit"]
    )
    save(made, **merges._asdict(), sums=whole, pairs=pairs, first=first)
    save(made, edge_patch=patch[edge], edge_keys=every[edge], open=opened)
    near = borders.neighbours_of(keys)
    names = tiles + task["beside"]
    return {
        "patches": len(whole),
        "border_edges": len(patch),
        "matched_edges": 2 * len(inside),
        "outer_edges": len(edge),
        "border": int(border.sum()),
        "graph_bytes": graph_bytes(folders),
        "near": {str(tiles[k]): sorted(names[j] for j in near[k]) for k in range(len(tiles))},
    }


def graph_bytes(folders: list[Path]) -> int:
    """Return the size in bytes of the files from which the graph is made."""
    return sum(f.stat().st_size for folder in folders for f in folder.glob("*.npy") if f.stem in _GRAPH)


def totals(work: Path, groups: int) -> dict[str, Any]:
    """Return the sums over all groups, and the neighbours of each tile."""
    found = [values_of(of_tile(work, "group", k)) for k in range(groups)]
    names = ("patches", "border_edges", "matched_edges", "graph_bytes")
    sums: dict[str, Any] = {name: sum(each[name] for each in found) for name in names}
    # Each group counts its side of an edge between groups.
    sums["matched_edges"] += sum(each["outer_edges"] for each in found)
    near: dict[str, list[int]] = {}
    for each in found:
        near |= each["near"]
    return sums | {"near": near}


def limit_of(wanted: dict[str, Any]) -> float | None:
    """Return the price up to which groups merge with a tolerance: lower than all prices that the cut depends on."""
    if "tolerance" not in wanted:
        return None
    return steps.least_cost(wanted["tolerance"], wanted["noise"]) / _COARSER / 2


def level(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the price at which all groups are cut."""
    save(made, price=np.array(_price(work, "group", task["groups"], task["nodes"], task["target"])))
    return {}


def _price(work: Path, step: str, groups: int, nodes: int, target: int) -> float:
    """Return the price at which groups leave the target of the last merging and the extra nodes at their borders."""
    folders = [of_tile(work, step, k) for k in range(groups)]
    border = sum(values_of(folder)["border"] for folder in folders)
    prices = [load(folder, "price") for folder in folders]
    return steps.common_price(prices, nodes, int(_SPARE * target) + int(_WAITING * border))


def cut(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the graph that is left of a group after the cut."""
    folder = of_tile(work, "group", task["tile"])
    price = task["limit"] if "limit" in task else float(load(of_tile(work, "level", 0), "price"))
    sums, pairs, opened = load(folder, "sums"), load(folder, "pairs"), load(folder, "open")
    label = steps.labels_after(len(sums), steps.Merges(load(folder, "merged"), load(folder, "price")), price)
    sums, pairs, _ = steps.contracted(label, sums, pairs, np.zeros(len(pairs)))
    left = np.zeros(len(sums), np.uint8)
    left[label[opened > 0]] = 1
    save(made, label=label, sums=sums, pairs=pairs, open=left)
    save(made, edge_patch=label[load(folder, "edge_patch")], fringe_edge_keys=load(folder, "edge_keys"))
    return {"patches": len(sums)}


def regroup(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the merges of regions inside a group, by exact prices and lengths of borders."""
    folders = [of_tile(work, "touch", tile) for tile in task["own"]]
    rim = np.concatenate([load(folder, "rim") for folder in folders])
    outside = np.unique(rim[~np.isin(rim[:, 1], task["own"]), 0])
    pairs, lengths = (np.concatenate([load(folder, name) for folder in folders]) for name in ("pairs", "lengths"))
    region, local = np.unique(pairs, return_inverse=True)
    sums = load(of_tile(work, task["sums"], 0), "sums", mapped=True)[region]
    join = of_tile(work, "join", 0)
    component, number = np.unique(load(join, "component")[region], return_inverse=True)
    found = steps.Components(number.astype(np.int32), load(join, "need")[component], 0, 0.0)
    border = np.isin(region, outside)
    target = int(_EARLY * task["share"] * len(region))
    price = {"smooth": task["smooth"], "error": task["error"], "proxies": task["target"], "area": task["area"]}
    graph = (sums, local.reshape(-1, 2).astype(np.int32), lengths, found, border)
    # If the number was found by a tolerance, merging ends at the cost at which regions are counted again.
    limit = math.inf if task["cost"] is None else task["cost"] / 2
    merges = steps.merge_inside(*graph, target, limit, **price)
    save(made, merged=region[merges.merged].reshape(-1, 2), price=merges.price)
    return {"regions": len(region), "border": int(border.sum())}


def price_of_regions(work: Path, groups: int, nodes: int, target: int) -> float:
    """Return the price at which groups leave about `target` regions."""
    return _price(work, "regroup", groups, nodes, target)


def merged_in_groups(work: Path, groups: int, nodes: int, price: float) -> NDArray[np.int32]:
    """Return the new region of each region after the merges of all groups below a price."""
    folders = [of_tile(work, "regroup", k) for k in range(groups)]
    pairs = np.concatenate([load(folder, "merged") for folder in folders])
    prices = np.concatenate([load(folder, "price") for folder in folders])
    order = np.argsort(prices, kind="stable")  # groups share no node, and the order inside a group stays
    return steps.labels_after(nodes, steps.Merges(pairs[order], prices[order]), price)


def rim_of(halo: borders.Halo, label: NDArray[np.int32], own: int) -> NDArray[np.int32]:
    """Return (N, 2) pairs of a region and another tile: regions at vertices of that tile, own and in the halo."""
    region = np.concatenate([label[halo.touch_face], label[own:]])
    tile = np.concatenate([halo.touch_tile, halo.tile])
    rows = np.unique(np.stack([region, tile], 1), axis=0)
    return rows[rows[:, 0] >= 0].astype(np.int32)
