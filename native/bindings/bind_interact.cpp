// The Python functions that edit regions.
#include <pybind11/stl.h>

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/interact/statistics.h"
#include "kept_mesh.h"
#include "options.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

std::int32_t to_index(const py::object& value, const char* name) {
  using Limits = std::numeric_limits<std::int32_t>;
  return static_cast<std::int32_t>(to_integer(value, name, Limits::min(), Limits::max()));
}

std::vector<std::int32_t> to_faces(const py::object& faces) { return read_indices(faces, "faces", "(K,)"); }

Vec3 to_direction(const std::optional<py::object>& direction) {
  if (!direction) return Vec3::Zero();
  return read_direction(*direction, "direction");
}

using EditAtFace = Partition (*)(const Mesh&, const Partition&, std::int32_t, Job&);

void bind_at_face(py::module_& m, const char* name, EditAtFace edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& face, Job* job) {
        const std::int32_t index = to_index(face, "face");
        return call_here(job, [&](Job& j) { return edit(mesh, part, index, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, py::kw_only(), "job"_a = py::none(), doc);
}

using EditByNumber = Partition (*)(const Mesh&, const Partition&, std::int32_t, std::int32_t, Job&);

void bind_rings(py::module_& m, const char* name, EditByNumber edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& face, const py::object& rings, Job* job) {
        const std::int32_t index = to_index(face, "face"), count = to_index(rings, "rings");
        return call_here(job, [&](Job& j) { return edit(mesh, part, index, count, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "rings"_a = 1, py::kw_only(), "job"_a = py::none(), doc);
}

void bind_times(py::module_& m, const char* name, EditAtFace edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& times, Job* job) {
        const std::int32_t count = to_index(times, "times");
        return call(job, [&](Job& j) { return edit(mesh, part, count, j); });
      },
      "mesh"_a, "partition"_a, "times"_a = 1, py::kw_only(), "job"_a = py::none(), doc);
}

void bind_lock(py::module_& m, const char* name, std::uint8_t lock, const char* doc) {
  m.def(
      name,
      [lock](const KeptMesh& mesh, const Partition& part, const py::object& faces) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        const Unlocked unlocked;
        return set_locked(mesh, part, indices, lock);
      },
      "mesh"_a, "partition"_a, "faces"_a, doc);
}

void bind_split_and_merge(py::module_& m) {
  m.def(
      "merge_regions",
      [](const KeptMesh& mesh, const Partition& part, const py::object& face, const py::object& other, Job* job) {
        const std::int32_t into = to_index(face, "face"), gone = to_index(other, "other");
        return call_here(job, [&](Job& j) { return merge_regions(mesh, part, into, gone, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "other"_a, py::kw_only(), "job"_a = py::none(),
      R"(Merge the region of `other` into the region of `face`. Returns a new Partition.

No other face changes its region. The merged region keeps the number of the region of `face`; numbers above that of the
other region decrease by one.
Raises InvalidInput (no such face, both in one region, no neighbours, one of them locked) or Cancelled.)");
  bind_at_face(m, "split_region", &split_region,
               R"(Split the region of a face into the two parts whose normals differ most. Returns a new Partition.

A planar region is split in the middle of its length. The part without the face becomes the last region. No face of
another region changes its region. Raises InvalidInput (no such face, its region is a single face or locked) or Cancelled.)");
  m.def(
      "split_along",
      [](const KeptMesh& mesh, const Partition& part, const py::object& face, const py::object& line,
         const std::optional<py::object>& direction, Job* job) {
        const std::int32_t index = to_index(face, "face");
        const std::vector<Vec3> points = read_points(line, "line", "(K, 3)");
        const Vec3 along = to_direction(direction);
        return call_here(job, [&](Job& j) { return split_along(mesh, part, index, points, along, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "line"_a, "direction"_a = py::none(), py::kw_only(), "job"_a = py::none(),
      R"(Split the region of a face along a line, as with a knife. Returns a new Partition.

line: (K, 3) points in scene units, extended straight at both ends. direction: (3,), the direction of the sweep, such as
the view direction; None: the region's normal. The side of a face is that of its centre. The part without the face becomes
the last region. No face of another region changes its region, and borders are not relaxed.
Raises InvalidInput (as split_region; no line; the whole region on one side) or Cancelled.)");
}

void bind_paint(py::module_& m) {
  m.def(
      "paint_faces",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, const std::optional<py::object>& onto,
         Job* job) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        const std::int32_t index = onto ? to_index(*onto, "onto") : kNone;
        if (onto && index < 0) throw InvalidInput("onto must be a face or None, got " + std::to_string(index));
        return call_here(job, [&](Job& j) { return paint_faces(mesh, part, indices, index, j); });
      },
      "mesh"_a, "partition"_a, "faces"_a, "onto"_a = py::none(), py::kw_only(), "job"_a = py::none(),
      R"(Add faces to a new region, or to the region of the face `onto`. Returns a new Partition.

faces: (K,) integers, rows of mesh.triangles. They must be connected, together with the region that takes them. A new
region is the last one. Parts that the faces cut off from other regions join the regions next to them. A region that is
painted over completely is removed. Faces of locked regions do not change. Borders are not relaxed.
Raises InvalidInput (no such face, nothing to paint, faces that are not connected) or Cancelled.)");
  m.def(
      "erase_faces",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, Job* job) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        return call_here(job, [&](Job& j) { return erase_faces(mesh, part, indices, j); });
      },
      "mesh"_a, "partition"_a, "faces"_a, py::kw_only(), "job"_a = py::none(),
      R"(Remove faces from the region of the first face; its neighbours take them. Returns a new Partition.

faces: (K,) integers, rows of mesh.triangles; faces of other regions do not change. A region that loses all its faces
is removed.
Raises InvalidInput (no such face, a locked region, no neighbour that can take the faces) or Cancelled.)");
  bind_rings(m, "grow_region", &grow_region,
             R"(Grow the region of a face by `rings` rings of faces. Returns a new Partition.

No region loses its last face. Raises InvalidInput (no such face, a locked region, no neighbour to take from) or
Cancelled.)");
  bind_rings(m, "shrink_region", &shrink_region,
             R"(Shrink the region of a face by `rings` rings of faces. Returns a new Partition.

Raises InvalidInput (no such face, a locked region, no neighbour, no face would be left) or Cancelled.)");
}

void bind_heuristics(py::module_& m) {
  bind_times(m, "add_worst", &add_worst,
             R"(Split the region whose split lowers the error most, `times` times. Returns a new Partition.

Locked regions are not chosen. Raises InvalidInput (no region left that can be split) or Cancelled.
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.5.)");
  bind_times(m, "delete_least", &delete_least,
             R"(Delete the `times` regions whose removal adds least error, one after another. Returns a new Partition.

Each is merged with a neighbour. Locked regions are not chosen.
Raises InvalidInput (no region with a neighbour is left) or Cancelled.)");
  bind_times(m, "merge_cheapest", &merge_cheapest,
             R"(Merge the two neighbours whose merge adds least error, `times` times. Returns a new Partition.

Locked regions are not chosen. Raises InvalidInput (no pair left) or Cancelled.)");
  m.def(
      "improve",
      [](const KeptMesh& mesh, const Partition& part, Job* job) {
        return call(job, [&](Job& j) { return improve(mesh, part, j); });
      },
      "mesh"_a, "partition"_a, py::kw_only(), "job"_a = py::none(),
      R"(Relax the borders, and move regions to places where they reduce the error more. Returns a new Partition.

The number of regions stays. Locked regions do not change. The error never grows. Raises Cancelled.
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.5 (region teleportation).)");
  m.def(
      "even_borders",
      [](const KeptMesh& mesh, const Partition& part, double strength, Job* job) {
        return call(job, [&](Job& j) { return even_borders(mesh, part, strength, j); });
      },
      "mesh"_a, "partition"_a, "strength"_a = 1.0, py::kw_only(), "job"_a = py::none(),
      R"(Make all borders short and straight. Returns a new Partition.

strength: in [0, 1], as PartitionOptions.smooth. The number of regions stays, creases stay borders, and locked regions do
not change. Raises InvalidInput or Cancelled.)");
}

py::dict as_dict(const RegionStatistics& s) {
  return py::dict("region"_a = s.region, "faces"_a = s.faces, "area"_a = s.area, "error"_a = s.error,
                  "distance_rms"_a = s.distance_rms, "distance_max"_a = s.distance_max, "locked"_a = s.locked,
                  "neighbours"_a = s.neighbours);
}

void bind_statistics(py::module_& m) {
  m.def(
      "region_statistics",
      [](const KeptMesh& mesh, const Partition& part, const py::object& face, Job* job) {
        const std::int32_t index = to_index(face, "face");
        return as_dict(call_here(job, [&](Job& j) { return region_statistics(mesh, part, index, j); }));
      },
      "mesh"_a, "partition"_a, "face"_a, py::kw_only(), "job"_a = py::none(),
      R"(Figures of the region of a face, as a dict.

region: its number. faces: their number. area: scene units squared. error: its part of partition.error. distance_rms,
distance_max: of the surface from the region's plane, scene units. locked. neighbours: the regions that share an edge with it.
Raises InvalidInput (no such face, or it was left out) or Cancelled.)");
  m.def(
      "all_statistics",
      [](const KeptMesh& mesh, const Partition& part, Job* job) {
        const auto all = call(job, [&](Job& j) { return all_statistics(mesh, part, j); });
        py::list list;
        for (const RegionStatistics& s : all) list.append(as_dict(s));
        return list;
      },
      "mesh"_a, "partition"_a, py::kw_only(), "job"_a = py::none(),
      "The figures of every region, in order, as a list of dicts; see region_statistics. Raises InvalidInput or "
      "Cancelled. Cost: O(F).");
  m.def(
      "region_sides",
      [](const py::object& vertices, const py::object& triangles, const py::object& region, const py::object& regions) {
        const std::vector<Vec3> points = read_vertices(vertices);
        const std::vector<Triangle> corners = read_triangles(triangles, points.size());
        const std::vector<std::int32_t> numbers = read_indices(region, "region", "(T,)");
        const std::int32_t count = to_index(regions, "regions");
        RegionSides sides = call_here(nullptr, [&](Job&) { return region_sides(points, corners, numbers, count); });
        return py::make_tuple(owned(std::move(sides.area)), owned(std::move(sides.normal)));
      },
      "vertices"_a, "triangles"_a, "region"_a, "regions"_a,
      R"(The areas and normals of the regions of any triangles: (R,) and (R, 3) float64.

vertices: (V, 3). triangles: (T, 3). region: (T,) the region of each triangle, -1 for none. regions: their number, R.
normal: the sum of area times unit normal, as long as the area where a region is flat. Triangles that are not finite have
no area. Raises InvalidInput.
Cost: O(V + T).)");
}

}  // namespace

void bind_interact(py::module_& m) {
  bind_at_face(m, "add_proxy", &add_proxy, R"(Start a new region at a face: the thesis's `add`. Returns a new Partition.

face: row of mesh.triangles. The new region is the last one; all others keep their numbers. Only the region of the face and
the regions next to it change. A face of a component that was left out restores that component as one region.
Raises InvalidInput (no such face, its region is a single face or locked) or Cancelled.)");
  bind_at_face(m, "delete_proxy", &delete_proxy,
               R"(Delete the region of a face: the thesis's `del`. Returns a new Partition.

face: row of mesh.triangles. The regions next to it take its faces. Numbers above its number decrease by one.
Raises InvalidInput (no such face, it was left out, its region is locked or the only one of its component) or Cancelled.)");
  bind_split_and_merge(m);
  bind_paint(m);
  bind_lock(m, "lock_regions", kLocked,
            R"(Lock the regions of some faces: edits do not change them. Returns a new Partition.

faces: (K,) integers, rows of mesh.triangles, at least one in each region.
Raises InvalidInput (no face, no such face, or a face that was left out).)");
  bind_lock(m, "unlock_regions", 0, R"(Unlock the regions of some faces. Returns a new Partition.

Regions that are left out become ordinary regions again.
faces: as in lock_regions. Raises InvalidInput (as lock_regions).)");
  m.def(
      "leave_out_regions",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, bool box) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        const Unlocked unlocked;
        return set_locked(mesh, part, indices, box ? kBoxed : kLeftOut);
      },
      "mesh"_a, "partition"_a, "faces"_a, "box"_a = false,
      R"(Leave out the regions of some faces: polygonize makes no polygon of them. Returns a new Partition.

The polygons around end there as at a border of the scan. The regions are locked too; unlock_regions restores them. A
number of regions for a later partition with this one before it does not count them.
faces: as in lock_regions. box: a box replaces each group of adjacent regions; it stands on the neighbour with the longest
common border. Raises InvalidInput (as lock_regions).)");
  bind_heuristics(m);
  bind_statistics(m);
}

}  // namespace isimp::bindings
