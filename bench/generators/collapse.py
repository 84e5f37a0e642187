"""Decimation by edge collapse under quadric error (Garland and Heckbert 1997): small, sound, plain Python.

Good for the variants of the test shapes and scans of up to some 100,000 faces (about 1 ms a collapse).
"""

import heapq

import numpy as np

STEEP = 0.2  # a collapse may turn no face's normal further than to this cosine


def _face_planes(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(length > 0, length, 1)[:, None]
    return normal, -np.einsum("ij,ij->i", normal, a), length / 2


def _border_planes(vertices, faces, normal):
    """A plane through each border edge, upright on its face: it keeps borders where they are."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    _, where, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    alone = count[where.reshape(-1)] == 1
    edges, owner = edges[alone], owner[alone]
    along = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    upright = np.cross(along, normal[owner])
    length = np.linalg.norm(upright, axis=1)
    upright /= np.where(length > 0, length, 1)[:, None]
    offset = -np.einsum("ij,ij->i", upright, vertices[edges[:, 0]])
    return edges, upright, offset, np.einsum("ij,ij->i", along, along)


def _quadrics(vertices, faces):
    """(V, 10): xx xy xz xd yy yz yd zz zd dd of the planes at each vertex, weighted by area."""
    normal, offset, area = _face_planes(vertices, faces)
    result = np.zeros((len(vertices), 10))

    def add(corner, n, d, weight):
        x, y, z = n.T
        terms = [x * x, x * y, x * z, x * d, y * y, y * z, y * d, z * z, z * d, d * d]
        np.add.at(result, corner, np.stack(terms, 1) * weight[:, None])

    for k in range(3):
        add(faces[:, k], normal, offset, area / 3)
    edges, upright, offset, weight = _border_planes(vertices, faces, normal)
    for k in range(2):
        add(edges[:, k], upright, offset, weight)
    return [tuple(q) for q in result.tolist()]


def _error(q, p):
    x, y, z = p
    return (
        q[0] * x * x + 2 * q[1] * x * y + 2 * q[2] * x * z + 2 * q[3] * x
        + q[4] * y * y + 2 * q[5] * y * z + 2 * q[6] * y + q[7] * z * z + 2 * q[8] * z + q[9]
    )  # fmt: skip


def _best_place(q, u, v):
    """The place of the least quadric; the best of the ends and the middle if that place is ill-conditioned."""
    a, b, c, d, e, f, g, h, i, _ = q
    m0, m1, m2 = e * h - f * f, c * f - b * h, b * f - c * e
    det = a * m0 + b * m1 + c * m2
    scale = max(a, e, h)
    if det > 1e-6 * scale * scale * scale:
        x = -(m0 * d + m1 * g + m2 * i) / det
        y = -(m1 * d + (a * h - c * c) * g + (b * c - a * f) * i) / det
        z = -(m2 * d + (b * c - a * f) * g + (a * e - b * b) * i) / det
        return _error(q, (x, y, z)), (x, y, z)
    middle = tuple((s + t) / 2 for s, t in zip(u, v, strict=True))
    return min((_error(q, p), k, p) for k, p in enumerate((middle, u, v)))[::2]


def _cross(a, b, c):
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


class _Collapse:
    def __init__(self, vertices, faces):
        self.place = [tuple(p) for p in vertices.tolist()]
        self.faces = [tuple(f) for f in faces.tolist()]
        self.quadric = _quadrics(vertices, faces)
        self.around = [set() for _ in self.place]  # faces of each vertex
        for f, corners in enumerate(self.faces):
            for v in corners:
                self.around[v].add(f)
        self.version = [0] * len(self.place)
        self.heap = []
        for u, v in {(min(a, b), max(a, b)) for f in self.faces for a, b in zip(f, f[1:] + f[:1], strict=True)}:
            self.offer(u, v)

    def offer(self, u, v):
        u, v = min(u, v), max(u, v)
        q = tuple(a + b for a, b in zip(self.quadric[u], self.quadric[v], strict=True))
        error, place = _best_place(q, self.place[u], self.place[v])
        heapq.heappush(self.heap, (error, u, v, self.version[u], self.version[v], place))

    def ring(self, v):
        return {w for f in self.around[v] for w in self.faces[f]} - {v}

    def on_border(self, v):
        return len(self.ring(v)) != len(self.around[v])

    def flips(self, v, shared, place):
        for f in self.around[v] - shared:
            corners = [self.place[w] for w in self.faces[f]]
            before = _cross(*corners)
            after = _cross(*(place if w == v else p for w, p in zip(self.faces[f], corners, strict=True)))
            dot = sum(a * b for a, b in zip(before, after, strict=True))
            if dot <= STEEP * (sum(a * a for a in before) * sum(a * a for a in after)) ** 0.5:
                return True
        return False

    def collapse(self, u, v, place):
        """The number of removed faces; 0 if the collapse would spoil the surface."""
        shared = self.around[u] & self.around[v]
        if len(self.ring(u) & self.ring(v)) != len(shared):  # link condition
            return 0
        if len(shared) == 2 and self.on_border(u) and self.on_border(v):
            return 0
        if self.flips(u, shared, place) or self.flips(v, shared, place):
            return 0
        for f in shared:
            for w in self.faces[f]:
                self.around[w].discard(f)
            self.faces[f] = None
        for f in self.around[v]:
            self.faces[f] = tuple(u if w == v else w for w in self.faces[f])
        self.around[u] |= self.around[v]
        self.around[v] = set()
        self.place[u] = place
        self.quadric[u] = tuple(a + b for a, b in zip(self.quadric[u], self.quadric[v], strict=True))
        self.version[u] += 1
        self.version[v] = -1
        for w in sorted(self.ring(u)):
            self.offer(u, w)
        return len(shared)


def decimated(vertices, faces, share):
    """The surface with `share` of its faces: vertices (V', 3) float64, faces (F', 3) int64."""
    state = _Collapse(vertices, faces)
    left, goal = len(faces), int(len(faces) * share)
    while left > goal and state.heap:
        _, u, v, at_u, at_v, place = heapq.heappop(state.heap)
        if state.version[u] == at_u and state.version[v] == at_v:
            left -= state.collapse(u, v, place)
    kept = np.array([f for f in state.faces if f is not None])
    used, index = np.unique(kept, return_inverse=True)
    return np.array(state.place)[used], index.reshape(-1, 3)
