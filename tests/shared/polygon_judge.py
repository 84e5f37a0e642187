"""Judges a polygon mesh against the scan it was made of, from arrays alone and by other means than the engine's own.

Signs of determinants are exact.

A polygon is flipped if it faces away from the surface that it stands for. Its outline on the scan determines this: it
runs along the borders of its region, and straight from corner to corner where a region was cut further. All surfaces
with one outline have one vector area, however they are folded in between, so that the outline determines the direction
of the polygon even where sheets of the scan lie on each other. The adjacent faces of the region can't determine it
there, as some belong to another sheet that other polygons stand for. Where part of the outline is guessed, as a
straight cut, the adjacent faces count too, if no two of them are more than 90 degrees apart: then both have to
contradict the polygon. The border of a region determines the sense of its outlines; as an edge runs once each way, it
does for all of its polygons at once (at a pinch, single ones may have taken over faces of another region, and run along
the border's other side).
"""

from dataclasses import dataclass, field

import numpy as np

from tests.shared.outlines import Outlines, edges_of, twins
from tests.shared.signs import signs_2d, signs_3d

THIN = 1e-6  # share of the diagonal: a polygon thinner than this has no area
SLIVER = 1e18  # cost of a triangle that is too thin, in squares of the bound
FACING = 0.2  # cosine from which a polygon faces the way of the adjacent faces


@dataclass
class Verdict:
    """Lists of polygons (by index) or of pairs; `defects` are texts on forbidden states."""

    defects: list = field(default_factory=list)
    crossing: list = field(default_factory=list)
    empty: list = field(default_factory=list)
    given: list = field(default_factory=list)  # without area, but so is the face of the scan that they are
    flipped: list = field(default_factory=list)
    bent: list = field(default_factory=list)
    far: list = field(default_factory=list)  # corners
    hits: list = field(default_factory=list)  # pairs of polygons that meet where the scan does not
    excused: list = field(default_factory=list)  # pairs that meet where the scan does too
    bend: np.ndarray = None  # bend of each polygon, scene units
    area: np.ndarray = None
    facets: np.ndarray = None  # (T, 3) corners of a triangulation

    @property
    def sound(self):
        return not (self.defects or self.crossing or self.empty or self.flipped or self.bent or self.far or self.hits)


def polygons_of(poly):
    return np.split(np.asarray(poly.loops), poly.loop_start[1:])


def groups(n, pairs):
    """How many groups n things form when the things of each pair belong together, and the group of each."""
    label = np.arange(n)
    pairs = np.asarray(pairs).reshape(-1, 2)
    while len(pairs):
        roots = label[pairs]
        np.minimum.at(label, roots.max(1), roots.min(1))
        while (label != label[label]).any():
            label = label[label]
        pairs = pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]
    return len(np.unique(label)), label


def topology(loops):
    """Faults, and Euler number, components, border loops and border edges of a mesh of polygons."""
    edges, following, owner = edges_of(loops)
    defects = []
    order = np.lexsort(edges.T[::-1])
    ordered = edges[order]
    if (ordered[1:] == ordered[:-1]).all(1).any():
        defects.append("an edge runs twice one way")
    other = twins(edges)
    paired = other >= 0
    used = np.unique(edges)
    fans, _ = groups(len(edges), np.stack([np.flatnonzero(paired), following[other[paired]]], 1))
    if fans != len(used):
        defects.append(f"{fans} fans for {len(used)} vertices")
    parts, _ = groups(len(loops), np.stack([owner[paired], owner[other[paired]]], 1))
    border = np.searchsorted(used, edges[~paired])
    if len(border) and not (np.bincount(border.ravel()) <= 2).all():
        defects.append("a border passes a vertex twice")
    rings = len(np.unique(groups(len(used), border)[1][border])) if len(border) else 0
    count = int((~paired).sum() + paired.sum() // 2)
    return defects, {
        "euler": len(used) - count + len(loops),
        "components": parts,
        "border loops": rings,
    }


def vector_area(points):
    around = points - points[0]
    return cross(around[:-1], around[1:]).sum(0) / 2


def cross(u, v):
    """As numpy's, of (N, 3) or (3); quicker for few."""
    x, y, z = u.T
    a, b, c = v.T
    return np.stack([y * c - z * b, z * a - x * c, x * b - y * a], -1)


def boxes_meet_2d(a, b, c, d):
    return ((np.maximum(a, b) >= np.minimum(c, d)) & (np.maximum(c, d) >= np.minimum(a, b))).all(1)


def segments_meet_2d(a, b, c, d):
    """Whether closed segments ab and cd have a point in common."""
    result = boxes_meet_2d(a, b, c, d)
    k = np.flatnonzero(result)
    if len(k):
        a, b, c, d = a[k], b[k], c[k], d[k]
        apart = signs_2d(a, b, c) * signs_2d(a, b, d) > 0
        apart |= signs_2d(c, d, a) * signs_2d(c, d, b) > 0
        result[k] = ~apart
    return result


def flat(points):
    """A polygon in its plane (n, 2), its vector area, and its largest distance from the plane."""
    area = vector_area(points)
    normal = area / max(np.linalg.norm(area), 1e-300)
    centred = points - points.mean(0)
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    u = cross(normal, axis)
    u /= max(np.linalg.norm(u), 1e-300)
    return centred @ np.stack([u, cross(normal, u)], 1), area, np.abs(centred @ normal).max()


def crosses_itself(p):
    """Whether two edges of a polygon in the plane meet elsewhere than where they follow each other."""
    n = len(p)
    q, back = p[np.arange(1, n + 1) % n], p[np.arange(n) - 1]
    if n > 3:
        i, j = np.triu_indices(n, 2)
        apart = j - i < n - 1
        if segments_meet_2d(p[i[apart]], q[i[apart]], p[j[apart]], q[j[apart]]).any():
            return True
    # A spike: two edges in a row that run back over each other.
    return bool(((signs_2d(back, p, q) == 0) & (((p - back) * (q - p)).sum(1) < 0)).any())


def least_surface(points, p, thin=0.0):
    """Triangles (local corners) of the least area that do not fold over in the plane; None if there are none.

    Triangles that are thinner than `thin` are used only if there is no other way.
    """
    n = len(p)
    if n == 3:
        return [(0, 1, 2)]
    seen = np.full((n, n), True)
    for s in range(n - 2):
        t, e = (each.ravel() for each in np.meshgrid(np.arange(s + 2, n - (s == 0)), np.arange(n), indexing="ij"))
        after = (e + 1) % n
        far = (e != s) & (e != t) & (after != s) & (after != t)
        t, e, after = t[far], e[far], after[far]
        meet = segments_meet_2d(np.broadcast_to(p[s], (len(e), 2)), p[t], p[e], p[after])
        seen[s, t[meet]] = False
    cost, via = np.zeros((n, n)), np.zeros((n, n), int)
    for gap in range(2, n):
        s = np.arange(n - gap)
        cost[s, s + gap] = np.inf
        s = s[seen[s, s + gap]]
        t, k = (s + gap)[:, None], s[:, None] + np.arange(1, gap)
        begin, middle, end = (np.broadcast_to(points[each], (*k.shape, 3)) for each in (s[:, None], k, t))
        size = np.linalg.norm(np.cross(middle - begin, end - middle), axis=2)
        longest = np.max([np.linalg.norm(side, axis=2) for side in (middle - begin, end - middle, end - begin)], axis=0)
        size = size + np.where(size <= thin * longest, SLIVER * thin * thin, 0)
        turns = signs_2d(*(np.broadcast_to(p[each], (*k.shape, 2)).reshape(-1, 2) for each in (s[:, None], k, t)))
        sums = cost[s[:, None], k] + cost[k, t] + np.where(turns.reshape(k.shape) > 0, size, np.inf)
        via[s, s + gap] = s + 1 + sums.argmin(1)
        cost[s, s + gap] = sums.min(1)
    if not np.isfinite(cost[0, n - 1]):
        return None
    triangles, stack = [], [(0, n - 1)]
    while stack:
        s, t = stack.pop()
        if t - s >= 2:
            m = via[s, t]
            triangles.append((s, m, t))
            stack += [(s, m), (m, t)]
    return triangles


def box_pairs(points, triangles, other_points=None, others=None):
    """Pairs of triangles whose boxes meet: within one set (i < j), or between two."""
    low, high = points[triangles].min(1), points[triangles].max(1)
    same = others is None
    low2, high2 = (low, high) if same else (other_points[others].min(1), other_points[others].max(1))
    found = []
    order = np.argsort(low2[:, 0])
    starts = low2[order, 0]
    step = max(1, 4_000_000 // max(len(low2), 1))
    for s in range(0, len(low), step):
        lows, highs = low[s : s + step], high[s : s + step]
        last = np.searchsorted(starts, highs[:, 0].max(), "right")
        near = order[:last]
        near = near[high2[near, 0] >= lows[:, 0].min()]
        meet = (lows[:, None] <= high2[None, near]).all(2) & (highs[:, None] >= low2[None, near]).all(2)
        i, j = np.nonzero(meet)
        i, j = i + s, near[j]
        keep = i < j if same else np.full(len(i), True)
        found.append(np.stack([i[keep], j[keep]], 1))
    return np.concatenate(found) if found else np.zeros((0, 2), int)


def segment_meets_triangle(p, q, a, b, c):
    """Whether closed segments pq meet closed triangles abc (N, 3 each); exactly."""
    side_p, side_q = signs_3d(a, b, c, p), signs_3d(a, b, c, q)
    result = side_p * side_q <= 0
    in_plane = (side_p == 0) & (side_q == 0)
    k = np.flatnonzero(result & ~in_plane)
    if len(k):
        turns = np.stack([signs_3d(p[k], q[k], x[k], y[k]) for x, y in ((a, b), (b, c), (c, a))])
        result[k] = (turns >= 0).all(0) | (turns <= 0).all(0)
    k = np.flatnonzero(in_plane)
    if len(k):
        p, q, a, b, c = seen_flat(a[k], b[k], c[k], p[k], q[k], a[k], b[k], c[k])
        turns = np.stack([signs_2d(x, y, p) for x, y in ((a, b), (b, c), (c, a))])
        some = (turns >= 0).all(0) | (turns <= 0).all(0)
        for x, y in ((a, b), (b, c), (c, a)):
            some |= segments_meet_2d(p, q, x, y)
        result[k] = some
    return result


def seen_flat(a, b, c, *points):
    """Points (N, 3) without the axis along which the triangles abc are seen largest."""
    axis = np.abs(np.cross(b - a, c - a)).argmax(1)
    kept = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    return [np.take_along_axis(p, kept, 1) for p in points]


def meeting(points, f, g):
    """The pairs of triangles f, g (N, 3) that meet elsewhere than in the corners they share."""
    same = f[:, :, None] == g[:, None, :]
    shared = same.sum((1, 2))
    result = shared >= 3
    a, b = points[f], points[g]
    k = not_apart(a, b, np.flatnonzero(shared == 0), 3)
    if len(k):
        some = np.zeros(len(k), bool)
        for x, y in ((a[k], b[k]), (b[k], a[k])):
            for e in range(3):
                some |= segment_meets_triangle(x[:, e], x[:, (e + 1) % 3], y[:, 0], y[:, 1], y[:, 2])
        result[k] = some
    k = not_apart(a, b, np.flatnonzero(shared == 1), 2)
    if len(k):
        some = np.zeros(len(k), bool)
        rows = np.arange(len(k))
        for x, y, at in ((a[k], b[k], same[k].any(2).argmax(1)), (b[k], a[k], same[k].any(1).argmax(1))):
            some |= segment_meets_triangle(x[rows, (at + 1) % 3], x[rows, (at + 2) % 3], y[:, 0], y[:, 1], y[:, 2])
        result[k] = some
    k = np.flatnonzero(shared == 2)
    free_f, free_g = (~same[k].any(2)).argmax(1), (~same[k].any(1)).argmax(1)
    p, q, r, s = a[k, (free_f + 1) % 3], a[k, (free_f + 2) % 3], a[k, free_f], b[k, free_g]
    flat = np.flatnonzero(signs_3d(p, q, r, s) == 0)  # they meet only if one lies folded on the other
    p, q, r, s = seen_flat(p[flat], q[flat], r[flat], p[flat], q[flat], r[flat], s[flat])
    result[k[flat]] = signs_2d(p, q, r) == signs_2d(p, q, s)
    return result


def not_apart(a, b, k, free):
    """The pairs of k in which no triangle has all its `free` corners, those not shared, on one side of the other."""
    for x, y in ((a, b), (b, a)):
        sides = [signs_3d(*(x[k, i] for i in range(3)), y[k, j]) for j in range(3)]
        k = k[np.abs(np.sum(sides, axis=0)) < free]
    return k


class Scan:
    """The triangles that were kept, and queries by place."""

    def __init__(self, mesh, face_region):
        self.vertices = np.asarray(mesh.vertices, float)
        kept = np.asarray(face_region) >= 0
        self.triangles, self.region = np.asarray(mesh.triangles)[kept], np.asarray(face_region)[kept]
        corners = self.vertices[self.triangles]
        self.vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.middle = corners.mean(1)
        self.area = np.linalg.norm(self.vector, axis=1)
        order = np.argsort(self.region, kind="stable")
        self.order, self.starts = order, np.searchsorted(self.region[order], np.arange(self.region.max() + 2))
        self.diagonal = np.linalg.norm(np.ptp(self.vertices[np.unique(mesh.triangles)], axis=0))
        self.flat = set()
        self.stored = self.vertices.astype(np.float32).astype(float)

    def has_flat_face(self, vertices):
        """Whether these are the corners of a face without area."""
        if not self.flat:
            corners = self.stored[self.triangles]
            area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
            extent = np.linalg.norm(corners - corners.mean(1, keepdims=True), axis=2).max(1)
            flat = area <= THIN * self.diagonal * extent
            self.flat = {(), *map(tuple, np.sort(self.triangles[flat], 1).tolist())}
        return tuple(sorted(vertices.tolist())) in self.flat

    def faces_of(self, region):
        return self.order[self.starts[region] : self.starts[region + 1]]

    def vectors_near(self, region, place, radius):
        """The vector areas of a region's faces around a place, of the nearest one at least."""
        faces = self.faces_of(region)
        distance = np.linalg.norm(self.middle[faces] - place, axis=1)
        return self.vector[faces[distance <= max(radius, distance.min())]]

    def meet(self, pairs):
        """By pairs (a, b) of regions: whether faces of both meet elsewhere than in the vertices they share."""
        pairs = {tuple(sorted(pair)) for pair in pairs}
        found = [np.zeros((0, 2, 3), int), *(self.near_faces(a, b) for a, b in pairs)]
        faces, pair = np.concatenate(found), np.repeat(np.arange(len(found)), [len(each) for each in found])
        other = (faces[:, 0] != faces[:, 1]).any(1)
        meets = meeting(self.stored, faces[other, 0], faces[other, 1])
        met = set(pair[other][meets].tolist())
        return {each: k in met for k, each in enumerate(pairs, 1)}

    def near_faces(self, a, b):
        """The pairs of a face of region a and one of region b, (N, 2, 3), whose boxes meet."""
        f, g = (self.triangles[faces[self.area[faces] > 0]] for faces in map(self.faces_of, (a, b)))
        f, g = self.within_box(f, g), self.within_box(g, f)
        pairs = box_pairs(self.stored, f, self.stored, g)
        return np.stack([f[pairs[:, 0]], g[pairs[:, 1]]], 1)

    def within_box(self, f, g):
        """The faces of f whose boxes meet the box around all of g."""
        corners, others = self.stored[f], self.stored[g.ravel()]
        if not len(others):
            return f[:0]
        reach = (corners.min(1) <= others.max(0)) & (corners.max(1) >= others.min(0))
        return f[reach.all(1)]

    def samples(self, count):
        """Points spread over the surface, the same every time."""
        random = np.random.default_rng(5)
        faces = random.choice(len(self.triangles), count, p=self.area / self.area.sum())
        u, v = random.random((2, count))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = (self.vertices[self.triangles[faces, k]] for k in range(3))
        return a + (b - a) * u[:, None] + (c - a) * v[:, None]


def distance_to_triangles(p, a, b, c):
    """The distance of each point to its triangle, all (N, 3)."""
    ab, ac = b - a, c - a
    n = np.cross(ab, ac)
    size = np.maximum((n * n).sum(1), 1e-300)
    v = (np.cross(p - a, ac) * n).sum(1) / size
    w = (np.cross(ab, p - a) * n).sum(1) / size
    best = np.where((v >= 0) & (w >= 0) & (v + w <= 1), np.abs(((p - a) * n).sum(1)) / np.sqrt(size), np.inf)
    for s, t in ((a, b), (b, c), (c, a)):
        d = t - s
        along = np.clip(((p - s) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(p - s - along[:, None] * d, axis=1))
    return best


def distances(points, corners, facets):
    """The distance from each point to the nearest of the triangles."""
    a, b, c = (corners[facets[:, k]] for k in range(3))
    middle = (a + b + c) / 3
    radius = np.sqrt(np.max([((x - middle) ** 2).sum(1) for x in (a, b, c)], axis=0))
    result = np.empty(len(points))
    step = max(1, 2_000_000 // len(facets))
    for s in range(0, len(points), step):
        part = points[s : s + step]
        apart = np.linalg.norm(part[:, None] - middle[None], axis=2)
        i, j = np.nonzero(apart - radius <= apart.min(1)[:, None])
        d = distance_to_triangles(part[i], a[j], b[j], c[j])
        nearest = np.full(len(part), np.inf)
        np.minimum.at(nearest, i, d)
        result[s : s + step] = nearest
    return result


def faces_away(area, outline, known, near):
    """Whether a polygon of this vector area faces away from its outline on the scan.

    If not all of that is `known`, as for a polygon inside a region that was split, a straight line replaces the rest
    and may turn the sum: it then has to face away from the faces `near` it as well, or, if these do not agree, at least
    not to face their way.
    """
    total = near.sum(0)
    agree = near @ total >= np.sqrt(0.5) * np.linalg.norm(total) * np.linalg.norm(near, axis=1)
    limit = 0 if agree.all() else FACING * np.linalg.norm(area) * np.linalg.norm(total)
    return area @ vector_area(outline) < 0 and (known or area @ total < limit)


def look_at_polygons(poly, scan, loops, position, flatness, outlined, v):
    facets, owner = [], []
    size = scan.diagonal
    if outlined:
        home, region_of = np.asarray(poly.source_vertex), np.asarray(poly.polygon_region)
        every = set(home.tolist())
        on_scan = Outlines(scan.triangles, scan.region)
        outlines = [on_scan.outline(r, home[loop].tolist(), every) for r, loop in zip(region_of, loops, strict=True)]
        along = np.bincount(region_of, [n for _, n, _ in outlines])
    v.bend, v.area = np.zeros(len(loops)), np.zeros(len(loops))
    for q, loop in enumerate(loops):
        points = position[loop]
        plane, area, v.bend[q] = flat(points)
        v.area[q] = np.linalg.norm(area)
        extent = np.linalg.norm(points - points.mean(0), axis=1).max()
        if v.area[q] <= THIN * size * extent:
            (v.given if scan.has_flat_face(poly.source_vertex[loop]) else v.empty).append(q)
            continue
        if flatness and v.bend[q] > flatness * size * (1 + 1e-6):
            v.bent.append(q)
        region, middle = poly.polygon_region[q], points.mean(0)
        if outlined:
            line, _, known = outlines[q]
            near = scan.vectors_near(region, middle, extent)
            flipped = along[region] < 0 or faces_away(area, scan.vertices[line], known, near)
        else:
            flipped = all(area @ scan.vectors_near(region, middle, radius).sum(0) <= 0 for radius in (extent, 0))
        if flipped:
            v.flipped.append(q)
        triangles = None if crosses_itself(plane) else least_surface(points, plane)
        if triangles is None:
            v.crossing.append(q)
            triangles = [(0, k, k + 1) for k in range(1, len(loop) - 1)]
            owner += [-1] * len(triangles)  # their intersections are not tested
        else:
            owner += [q] * len(triangles)
        facets += [loop[list(t)] for t in triangles]
    v.facets = np.array(facets)
    return np.array(owner)


def judge(poly, mesh, part, flatness=0.0, reach=0.02, outlined=False):
    """A Verdict on the polygons of a partition; `flatness` and `reach` as shares of the diagonal, 0 for no bound.

    `outlined`: the regions and vertices that polygons stand for are known, so that their outlines decide which are
    flipped. Where these are a guess, as in results of other programs, only the adjacent faces decide.
    """
    v = Verdict()
    scan = Scan(mesh, part.face_region)
    loops = polygons_of(poly)
    vertices = np.asarray(poly.vertices)
    if not np.isfinite(vertices).all():
        v.defects.append("a vertex is not finite")
        return v, scan
    if not np.array_equal(np.unique(poly.loops), np.arange(len(vertices))):
        v.defects.append("a vertex is unused or out of range")
        return v, scan
    if min(map(len, loops)) < 3 or any(len(set(loop.tolist())) < len(loop) for loop in loops):
        v.defects.append("a polygon repeats a vertex or has fewer than three")
        return v, scan
    if len({tuple(sorted(loop.tolist())) for loop in loops}) < len(loops):
        v.defects.append("two polygons have the same corners")
    defects, found = topology(loops)
    _, wanted = topology(scan.triangles)
    v.defects += defects + [f"{what} {found[what]}, scan {n}" for what, n in wanted.items() if found[what] != n]
    moved = np.linalg.norm(vertices - scan.vertices[poly.source_vertex], axis=1)
    v.far = np.flatnonzero(moved > reach * scan.diagonal * (1 + 1e-6)).tolist()
    position = vertices.astype(np.float32).astype(float)  # as stored in files
    owner = look_at_polygons(poly, scan, loops, position, flatness, outlined, v)
    full = np.linalg.norm(np.cross(position[v.facets[:, 1]] - position[v.facets[:, 0]],
                                   position[v.facets[:, 2]] - position[v.facets[:, 0]]), axis=1) > 0  # fmt: skip
    asked = np.flatnonzero((owner >= 0) & full)
    facets, owner = v.facets[asked], owner[asked]
    pairs = box_pairs(position, facets)
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    pairs = pairs[meeting(position, facets[pairs[:, 0]], facets[pairs[:, 1]])]
    met = sorted({tuple(sorted(pair)) for pair in owner[pairs].tolist()})
    regions = [tuple(sorted(poly.polygon_region[[a, b]].tolist())) for a, b in met]
    known = scan.meet(regions)
    for pair, key in zip(met, regions, strict=True):
        (v.excused if known[key] else v.hits).append(pair)
    return v, scan
