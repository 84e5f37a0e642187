"""Exact signs of determinants: float64 is used where its error bound allows, else Python's integers."""

import numpy as np


def signs_2d(a, b, c):
    """Turn of a, b, c (N, 2): 1 left, -1 right, 0 straight; exactly."""
    u, v = b - a, c - a
    return signs_of(np.stack([u[:, 0] * v[:, 1], -u[:, 1] * v[:, 0]]), 1e-14, a, b, c)


def signs_3d(a, b, c, d):
    """Side of d of the plane a, b, c; exactly."""
    u, v, w = ((other - a).T for other in (b, c, d))
    terms = [u[i] * v[j] * w[k] for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]
    terms += [-u[i] * v[j] * w[k] for i, j, k in ((0, 2, 1), (1, 0, 2), (2, 1, 0))]
    return signs_of(np.stack(terms), 4e-15, a, b, c, d)


def signs_of(terms, unit, *points):
    """Signs of sums of terms (K, N), in integers where they are smaller than the error; all terms 0: the sum is 0."""
    det, size = terms.sum(0), np.abs(terms).sum(0)
    sign = np.sign(det).astype(int)
    unsure = np.flatnonzero((np.abs(det) <= unit * size) & (size > 0))
    if len(unsure):
        sign[unsure] = exact_signs(np.stack([p[unsure] for p in points]))
    return sign


def exact_signs(points):
    """Signs of the determinants of the differences from the first of points (3, N, 2) or (4, N, 3)."""
    share, exponent = np.frexp(points)
    shift = (exponent - exponent.min((0, 2))[:, None]).astype(object)
    whole = (share * 2.0**53).astype(np.int64).astype(object) << shift
    rows = (whole[1:] - whole[0]).transpose(0, 2, 1)
    if len(rows) == 2:
        (a, b), (c, d) = rows
        det = a * d - b * c
    else:
        (a, b, c), (d, e, f), (g, h, i) = rows
        det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return (det > 0).astype(int) - (det < 0).astype(int)
