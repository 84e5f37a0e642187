"""Round shapes, turned, of other sizes than in `round_shapes`: no number was chosen on them."""

import dataclasses

import numpy as np

from bench.generators.round_shapes import (
    Round,
    Shape,
    X,
    Z,
    any_of,
    ball,
    block,
    elbow,
    length,
    made,
    oval,
    polar,
    revolution,
    ring,
    rod,
    rounded,
    stadium,
    tube,
    turned,
    vault,
    with_noise,
    without,
)


def dented(p):
    """A can with two dents, of 3 % and 6 % of its radius."""
    rho, z = polar(p, (0, 0, 0), Z)
    angle = np.arctan2(p[:, 1], p[:, 0])
    dents = 0.06 * np.exp(-(((angle - 1) / 0.35) ** 2) - ((z - 0.3) / 0.4) ** 2)
    dents += 0.03 * np.exp(-(((angle + 1.6) / 0.25) ** 2) - ((z + 0.6) / 0.3) ** 2)
    return np.maximum(rho - 1 + dents, np.abs(z) - 1.5)


def more_shapes():
    cone, cone_side = turned((-1, 1), (1.4, 0.25), smooth=False)
    tip, tip_side = turned((-1.2, 1.2), (0.9, 0.001), smooth=False)
    vase, vase_side = turned((-1.8, -0.9, 0.2, 1.2, 1.8), (0.5, 0.95, 0.7, 0.9, 1.1))
    post, post_side = turned((-2, -1.4, -0.6, 0.3, 1.2, 2), (0.5, 0.35, 0.7, 0.45, 0.3, 0.5))
    roof, roof_side = turned((1.199, 2.0), (0.8, 0.2), smooth=False)
    box, fillets = rounded((0.9, 1.1, 0.4), 0.2)
    pipe, bend = elbow(1.3, 0.45, -1, -0.8, (1, 0.8))
    side = oval(1.5)
    holes = [((-1.0, 0.4, 0), 0.4), ((0.4, -0.3, 0), 0.6), ((1.4, 0.5, 0), 0.25)]
    leaning = (0.2, -0.4, 1)
    return {
        "long rod": Shape(lambda p: rod(p, (0, 0, 0), leaning, 0.6, 1.8), (1.7, 2.1), [tube(0.6, leaning)]),
        "dented can": Shape(dented, (1.2, 1.7), [tube(1, Z)]),
        "post": Shape(
            any_of(
                lambda p: rod(p, (0, 0, 0), Z, 0.6, 2.05),
                lambda p: block(p, (0, 0, -2.2), (0.9, 0.9, 0.2)),
                lambda p: block(p, (0, 0, 2.2), (0.8, 0.8, 0.2)),
            ),
            (1.05, 2.6),
            [tube(0.6, Z)],
        ),
        "stump": Shape(cone, (1.6, 1.2), [Round("cone", cone_side, None, tuple(Z))]),
        "tip": Shape(tip, (1.1, 1.4), [Round("cone", tip_side, None, tuple(Z))]),
        "bowl": Shape(
            any_of(lambda p: block(p, (0, 0, -0.8), (1.4, 1.1, 0.8)), lambda p: length(p) - 0.9),
            (1.6, 1.8),
            [ball(0.9)],
        ),
        "tyre": Shape(lambda p: ring(p, 1.7, 0.45), (2.3, 0.65), [revolution(lambda p: ring(p, 1.7, 0.45))]),
        "pipe": Shape(pipe, (2.3, 2.3), bend),
        "leg": Shape(
            any_of(post, lambda p: block(p, (0, 0, -2.2), (0.7, 0.6, 0.25))), (0.9, 2.6), [revolution(post_side)]
        ),
        "jar": Shape(vase, (1.3, 2.0), [revolution(vase_side)]),
        "soap": Shape(box, (1.5, 1.5), fillets),
        "bridge": Shape(
            without(lambda p: block(p, (0, 0, 0.1), (2.0, 1.5, 1.6)), vault(1.1, -1.5)), (2.2, 2.0), [tube(1.1, X)]
        ),
        "bracket": Shape(
            without(
                lambda p: block(p, (0, 0, 0), (1.9, 1.2, 0.3)),
                *[lambda p, c=c, r=r: rod(p, c, Z, r, 2) for c, r in holes],
            ),
            (2.1, 0.6),
            [tube(r, Z, c) for c, r in holes],
        ),
        "cross": Shape(
            any_of(lambda p: rod(p, (0, 0, 0), X, 0.6, 2.0), lambda p: rod(p, (0.2, 0, 0), Z, 0.5, 1.8)),
            (2.2, 2.0),
            [tube(0.6, X), tube(0.5, Z, (0.2, 0, 0))],
        ),
        "pill": Shape(
            lambda p: length(p - np.clip(p[:, 2], -1.3, 1.3)[:, None] * Z) - 0.6,
            (0.8, 2.1),
            [tube(0.6, Z), ball(0.6, (0, 0, 1.3)), ball(0.6, (0, 0, -1.3))],
        ),
        "bin": Shape(
            any_of(lambda p: rod(p, (0, 0, -0.2), Z, 0.8, 1.4), roof),
            (1.0, 2.2),
            [tube(0.8, Z), Round("cone", roof_side, None, tuple(Z))],
        ),
        "axle": Shape(
            any_of(
                lambda p: rod(p, (0, 0, -1.2), Z, 0.4, 0.9),
                lambda p: rod(p, (0, 0, 0), Z, 0.9, 0.4),
                lambda p: rod(p, (0, 0, 1.2), Z, 0.6, 0.9),
            ),
            (1.1, 2.3),
            [tube(0.4, Z), tube(0.9, Z), tube(0.6, Z)],
        ),
        "slab": Shape(
            without(
                lambda p: stadium(p, 1.2, 0.6, 0.25),
                lambda p: rod(p, (-1.2, 0, 0), Z, 0.3, 2),
                lambda p: rod(p, (1.2, 0, 0), Z, 0.35, 2),
            ),
            (2.0, 0.5),
            [tube(r, Z, (x, 0, 0)) for x, r in ((-1.2, 0.6), (1.2, 0.6), (-1.2, 0.3), (1.2, 0.35))],
        ),
        "tin": Shape(
            lambda p: np.maximum(side(p), np.abs(p[:, 2]) - 0.9), (1.7, 1.1), [Round("extrusion", side, None, tuple(Z))]
        ),
    }


def turned_shape(name, seed, noise, steps=52):
    """A shape turned by chance, with noise: its truth, clean vertices in its own frame, vertices and triangles."""
    shape = more_shapes()[name]
    vertices, faces = made(shape, steps)
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    if np.linalg.det(rotation) < 0:
        rotation = -rotation
    parts = [dataclasses.replace(p, axis=p.axis and tuple(rotation @ np.asarray(p.axis, float))) for p in shape.parts]
    return dataclasses.replace(shape, parts=parts), vertices, with_noise(vertices @ rotation.T, noise, seed + 1), faces
