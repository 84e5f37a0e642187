"""Finds the opening of a scan under the mouse, and makes its lines and its description. numpy only."""

from __future__ import annotations

import numpy as np

from .language import said

REACH = 24.0  #: pixels


def seen(points: np.ndarray, to_view: np.ndarray, size: tuple[float, float]) -> np.ndarray:
    """Return (N, 2) pixels of (N, 3) points, NaN behind the viewer. to_view: (4, 4) from their space to clip space."""
    there = np.column_stack([points, np.ones(len(points))]) @ np.asarray(to_view, float).T
    with np.errstate(divide="ignore", invalid="ignore"):
        flat = there[:, :2] / there[:, 3:]
    flat[there[:, 3] <= 0] = np.nan
    return (flat + 1) / 2 * np.asarray(size, float)


def nearest(openings: list[dict], to_view: np.ndarray, size: tuple[float, float], at) -> int | None:
    """Return the opening whose center or border is nearest to the mouse within REACH, or None."""
    best, found = REACH, None
    for number, opening in enumerate(openings):
        points = np.concatenate([[opening["center"]], *opening["loops"]])
        away = np.linalg.norm(seen(points, to_view, size) - np.asarray(at, float), axis=1)
        away = float(np.nanmin(away)) if np.isfinite(away).any() else np.inf
        if away < best:
            best, found = away, number
    return found


def lines(openings: list[dict], origin=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Return (2 E, 3) float32 the borders of openings as pairs of points, relative to `origin`."""
    pairs = [
        np.stack([loop, np.roll(loop, -1, axis=0)], axis=1).reshape(-1, 3)
        for opening in openings
        for loop in map(np.asarray, opening["loops"])
    ]
    return (np.concatenate([np.empty((0, 3)), *pairs]) - np.asarray(origin, float)).astype(np.float32)


def cover(opening: dict) -> np.ndarray:
    """Return (3 T, 3) float32 triangles that cover an opening in a drawing: a fan around the middle of each border."""
    triangles = [np.empty((0, 3))]
    for loop in map(np.asarray, opening["loops"]):
        middle = np.broadcast_to(loop.mean(axis=0), loop.shape)
        triangles.append(np.stack([loop, np.roll(loop, -1, axis=0), middle], axis=1).reshape(-1, 3))
    return np.concatenate(triangles).astype(np.float32)


def told(opening: dict, length: str) -> str:
    """Return the description of the opening under the mouse. length: a text in the scene's units."""
    name = said("Hole") if opening["kind"] == "hole" else said("Tunnel or handle")
    state = said("kept open · click: close it") if opening["kept"] else said("closed · click: keep it open")
    return said("{opening}, {length} around", opening=name, length=length) + f" · {state}"
