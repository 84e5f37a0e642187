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
  const std::vector<double> numbers = read_numbers(*direction, "direction", "(3,)");
  if (numbers.size() != 3) throw InvalidInput("direction must have 3 numbers, got " + std::to_string(numbers.size()));
  return {numbers[0], numbers[1], numbers[2]};
}

using EditAtFace = Partition (*)(const Mesh&, const Partition&, std::int32_t, Job&);

void bind_at_face(py::module_& m, const char* name, EditAtFace edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& face, Job* job) {
        const std::int32_t index = to_index(face, "face");
        return call_here(job, [&](Job& j) { return edit(mesh, part, index, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "job"_a = py::none(), doc);
}

using EditByNumber = Partition (*)(const Mesh&, const Partition&, std::int32_t, std::int32_t, Job&);

void bind_rings(py::module_& m, const char* name, EditByNumber edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& face, const py::object& rings, Job* job) {
        const std::int32_t index = to_index(face, "face"), count = to_index(rings, "rings");
        return call_here(job, [&](Job& j) { return edit(mesh, part, index, count, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "rings"_a = 1, "job"_a = py::none(), doc);
}

void bind_times(py::module_& m, const char* name, EditAtFace edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& times, Job* job) {
        const std::int32_t count = to_index(times, "times");
        return call(job, [&](Job& j) { return edit(mesh, part, count, j); });
      },
      "mesh"_a, "partition"_a, "times"_a = 1, "job"_a = py::none(), doc);
}

void bind_lock(py::module_& m, const char* name, bool locked, const char* doc) {
  m.def(
      name,
      [locked](const KeptMesh& mesh, const Partition& part, const py::object& faces) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        const Unlocked unlocked;
        return set_locked(mesh, part, indices, locked);
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
      "mesh"_a, "partition"_a, "face"_a, "other"_a, "job"_a = py::none(),
      R"(Make the region of `other` part of the region of `face`. Returns a new Partition.

No other face changes sides. The merged region has the number of the region of `face`; those above the other's move down
by one. Raises InvalidInput (no such face, both in one region, no neighbours, one of them locked) or Cancelled.)");
  bind_at_face(m, "split_region", &split_region,
               R"(Split the region of a face in the two parts whose normals are most unlike. Returns a new Partition.

A flat region is split half-way along its length. The part without the face is the new region, the last one; no face of
any other region changes sides. Raises InvalidInput (no such face, its region is a single face or locked) or Cancelled.)");
  m.def(
      "split_along",
      [](const KeptMesh& mesh, const Partition& part, const py::object& face, const py::object& line,
         const std::optional<py::object>& direction, Job* job) {
        const std::int32_t index = to_index(face, "face");
        const std::vector<Vec3> points = read_points(line, "line", "(K, 3)");
        const Vec3 along = to_direction(direction);
        return call_here(job, [&](Job& j) { return split_along(mesh, part, index, points, along, j); });
      },
      "mesh"_a, "partition"_a, "face"_a, "line"_a, "direction"_a = py::none(), "job"_a = py::none(),
      R"(Split the region of a face along a line, as with a knife. Returns a new Partition.

line: (K, 3) points in scene units; it goes on straight at both ends. direction: (3,), along which it is swept, as that of
sight; None: the region's normal. Faces are parted by the side their middles lie on. The part without the face is the new
region, the last one; no face of any other region changes sides, and nothing is relaxed.
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
      "mesh"_a, "partition"_a, "faces"_a, "onto"_a = py::none(), "job"_a = py::none(),
      R"(Make faces a region of their own, or part of the region of the face `onto`. Returns a new Partition.

faces: (K,) integers, of mesh.triangles; they must hang together, with the region they become part of. A new region
is the last one. What they cut off from other regions goes to those around it, a region painted over wholly is gone, and
faces of locked regions stay as they are. Nothing is relaxed.
Raises InvalidInput (no such face, nothing to paint, faces that do not hang together) or Cancelled.)");
  m.def(
      "erase_faces",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, Job* job) {
        const std::vector<std::int32_t> indices = to_faces(faces);
        return call_here(job, [&](Job& j) { return erase_faces(mesh, part, indices, j); });
      },
      "mesh"_a, "partition"_a, "faces"_a, "job"_a = py::none(),
      R"(Take faces from the region of the first of them; the regions around flood them. Returns a new Partition.

faces: (K,) integers, of mesh.triangles; those of other regions stay as they are. A region erased wholly is gone.
Raises InvalidInput (no such face, a locked region, no neighbour that could take them) or Cancelled.)");
  bind_rings(m, "grow_region", &grow_region,
             R"(Let the region of a face take the faces beside it, `rings` times over. Returns a new Partition.

No region gives its last face. Raises InvalidInput (no such face, a locked region, no neighbour to take from) or
Cancelled.)");
  bind_rings(
      m, "shrink_region", &shrink_region,
      R"(Let the region of a face give the faces along its border away, `rings` times over. Returns a new Partition.

Raises InvalidInput (no such face, a locked region, no neighbour, nothing would be left of it) or Cancelled.)");
}

void bind_heuristics(py::module_& m) {
  bind_times(m, "add_worst", &add_worst,
             R"(Add a proxy at the worst face of the worst region, `times` times. Returns a new Partition.

Locked regions are not chosen. Raises InvalidInput (no region left that can be split) or Cancelled.
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.5.)");
  bind_times(m, "delete_least", &delete_least,
             R"(Delete the region whose loss costs least, `times` times. Returns a new Partition.

That is one which, merged with a neighbour, raises the error least. Locked regions are not chosen. Raises InvalidInput
(no region left that has such a neighbour) or Cancelled.)");
  bind_times(m, "merge_cheapest", &merge_cheapest,
             R"(Merge the two neighbours whose merging raises the error least, `times` times. Returns a new Partition.

Locked regions are not chosen. Raises InvalidInput (no pair left) or Cancelled.)");
  m.def(
      "improve",
      [](const KeptMesh& mesh, const Partition& part, Job* job) {
        return call(job, [&](Job& j) { return improve(mesh, part, j); });
      },
      "mesh"_a, "partition"_a, "job"_a = py::none(),
      R"(Relax borders and move regions from where they are worth little to where they are worth much. A new Partition.

The number of regions stays, locked ones do not change, and the error is never above what it was. Raises Cancelled.
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.5 (region teleportation).)");
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
      "mesh"_a, "partition"_a, "face"_a, "job"_a = py::none(),
      R"(What there is to say of the region of a face, as a dict.

region, faces; area, scene units squared; error, its share of partition.error; distance_rms and distance_max of the surface
from the region's plane, scene units; locked; neighbours, the numbers of the regions it shares an edge with.
Raises InvalidInput (no such face, or it was left out) or Cancelled.)");
  m.def(
      "all_statistics",
      [](const KeptMesh& mesh, const Partition& part, Job* job) {
        const auto all = call(job, [&](Job& j) { return all_statistics(mesh, part, j); });
        py::list list;
        for (const RegionStatistics& s : all) list.append(as_dict(s));
        return list;
      },
      "mesh"_a, "partition"_a, "job"_a = py::none(),
      "The same of every region, in their order, as a list of dicts. Raises InvalidInput or Cancelled. Cost: O(F).");
}

}  // namespace

void bind_interact(py::module_& m) {
  bind_at_face(m, "add_proxy", &add_proxy, R"(Start a new region at a face: the thesis's `add`. Returns a new Partition.

face: index into mesh.triangles. The new region is the last one, all others keep their numbers; only the region of the
face and those around it change. A face of a part that was left out brings that part back as one region.
Raises InvalidInput (no such face, its region is a single face or locked) or Cancelled.)");
  bind_at_face(m, "delete_proxy", &delete_proxy,
               R"(Take the region of a face away: the thesis's `del`. Returns a new Partition.

face: index into mesh.triangles. The regions around flood its faces; those above it move down by one number.
Raises InvalidInput (no such face, it was left out, its region is locked or the only one of its part) or Cancelled.)");
  bind_split_and_merge(m);
  bind_paint(m);
  bind_lock(m, "lock_regions", true,
            R"(Lock the regions of some faces: edits leave them as they are. Returns a new Partition.

faces: (K,) integers, of mesh.triangles, one or more of each region. Raises InvalidInput (no face, no such face, or
one that was left out).)");
  bind_lock(m, "unlock_regions", false, R"(Let edits change the regions of some faces again. Returns a new Partition.

faces: as for lock_regions. Raises InvalidInput (as lock_regions).)");
  bind_heuristics(m);
  bind_statistics(m);
}

}  // namespace isimp::bindings
