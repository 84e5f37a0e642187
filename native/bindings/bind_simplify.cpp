#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/part_of.h"
#include "isimp/mesh/shared_edges.h"
#include "isimp/simplify/constraints.h"
#include "isimp/simplify/edges.h"
#include "isimp/simplify/openings.h"
#include "isimp/simplify/within.h"
#include "kept_mesh.h"
#include "options.h"
#include "read_guides.h"

/// All names here are private to the package: guides.py, guided.py and within.py have the public names and texts.
namespace isimp::bindings {

using namespace py::literals;

namespace {

using Given = std::optional<py::object>;

std::vector<VertexPair> to_pairs(const Given& pairs, const char* name) {
  return pairs ? read_pairs(*pairs, name) : std::vector<VertexPair>();
}

std::optional<std::vector<std::int32_t>> to_optional_faces(const Given& faces) {
  return faces ? std::optional(read_indices(*faces, "faces", "(K,)")) : std::nullopt;
}

void bind_edges(py::module_& m) {
  m.def(
      "_inner_edges",
      [](const KeptMesh& mesh, Job* job) {
        InnerEdges found = call(job, [&](Job& j) { return inner_edges(mesh, j); });
        return py::make_tuple(owned(std::move(found.edges)), owned(std::move(found.face)),
                              owned(std::move(found.beside)));
      },
      "mesh"_a, "job"_a = py::none(), "See guides.inner_edges.");
  m.def(
      "_sharp_edges",
      [](const KeptMesh& mesh, double angle, Job* job) {
        return owned(call(job, [&](Job& j) { return sharp_edges(mesh, angle, j); }));
      },
      "mesh"_a, "angle"_a, "job"_a = py::none(), "See guides.sharp_edges.");
  m.def(
      "_marked_edges",
      [](const KeptMesh& mesh, const py::object& edges, Job* job) {
        const std::vector<VertexPair> marked = read_pairs(edges, "edges");
        return owned(call(job, [&](Job& j) { return marked_edges(mesh, marked, j); }));
      },
      "mesh"_a, "edges"_a, "job"_a = py::none(), "See guides.marked_edges.");
  m.def(
      "_shared_edges",
      [](const py::object& given, Job* job) {
        const std::vector<Triangle> triangles = read_triangles(given, std::numeric_limits<std::int32_t>::max());
        std::size_t count = 0;
        for (std::size_t f = 0; f < triangles.size(); ++f)
          for (const std::int32_t v : triangles[f]) {
            if (v < 0) throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(v));
            count = std::max(count, static_cast<std::size_t>(v) + 1);
          }
        SharedEdges found = call(job, [&](Job& j) { return shared_edges(count, triangles, j); });
        return py::make_tuple(owned(std::move(found.edges)), owned(std::move(found.face)),
                              owned(std::move(found.beside)));
      },
      "triangles"_a, "job"_a = py::none(), "See guides.shared_edges.");
}

void bind_openings(py::module_& m) {
  m.def(
      "opening_length",
      [](const KeptMesh& mesh, std::int32_t regions, Job* job) {
        return call(job, [&](Job& j) { return opening_length(mesh, regions, j); });
      },
      "mesh"_a, "regions"_a, py::kw_only(), "job"_a = py::none(),
      R"(The length up to which the loops of holes and handles are errors of scanning, in scene units.

Photogrammetry makes tunnels and pinholes that are too small for this number of regions, and each costs polygons. The
length is for fill_holes and cut_handles of CleanOptions. Components that a partition into as many regions leaves out by
default do not count. It is half of sqrt(area / regions), but at most 20 times the
mean edge, so that well sampled openings stay. It is rounded down to the mean edge times a power of sqrt(2). 0 if the mesh
has no opening, or so little noise that it was drawn and not scanned.
Raises InvalidInput (regions below 1) or Cancelled. Cost: O(V + F).)");
  m.def(
      "opening_lengths",
      [](const KeptMesh& mesh, std::int32_t regions, Job* job) {
        const OpeningLengths lengths = call(job, [&](Job& j) { return opening_lengths(mesh, regions, j); });
        return std::pair{lengths.holes, lengths.handles};
      },
      "mesh"_a, "regions"_a, py::kw_only(), "job"_a = py::none(),
      R"((fill_holes, cut_handles) for CleanOptions, as the command and the add-on use them: see opening_length.

Holes of up to 8 mean edges, such as a missing vertex makes, are filled up to sqrt(area / regions). `openings.lengths`
has the length of holes in walls too.)");
  m.def(
      "_all_opening_lengths",
      [](const KeptMesh& mesh, std::int32_t regions, const PartitionOptions& options, Job* job) {
        const OpeningLengths lengths = call(job, [&](Job& j) { return opening_lengths(mesh, regions, j, options); });
        return std::tuple{lengths.holes, lengths.flat_holes, lengths.handles};
      },
      "mesh"_a, "regions"_a, "options"_a, "job"_a = py::none(), "See openings.lengths.");
  m.def(
      "_guess_opening_lengths",
      [](const KeptMesh& mesh, const PartitionOptions& options, Job* job) {
        const GuessedLengths found = call(job, [&](Job& j) { return guess_opening_lengths(mesh, options, j); });
        const OpeningLengths& lengths = found.lengths;
        return std::tuple{lengths.holes, lengths.flat_holes, lengths.handles, found.most, found.likely};
      },
      "mesh"_a, "options"_a, "job"_a = py::none(), "See openings.lengths_for.");
  m.def(
      "_left_out_count",
      [](const KeptMesh& mesh, const PartitionOptions& options, Job* job) {
        return call(job, [&](Job& j) { return left_out_count(mesh, options, j); });
      },
      "mesh"_a, "options"_a, "job"_a = py::none(), "See openings.Lengths.");
}

void bind_constraints(py::module_& m) {
  m.def(
      "_partition",
      [](const KeptMesh& mesh, PartitionOptions options, Job* job, const Given& weights, const Given& barriers,
         const Given& cuts, const Given& faces, const Partition* before) {
        const Constraints constraints{.guides = read_guides(weights, barriers),
                                      .cuts = to_pairs(cuts, "cuts"),
                                      .faces = to_optional_faces(faces),
                                      .before = before};
        return call(job, [&](Job& j) { return mesh.partitioner().run(options, constraints, j); });
      },
      "mesh"_a, "options"_a, "job"_a = py::none(), "weights"_a = py::none(), "barriers"_a = py::none(),
      "cuts"_a = py::none(), "faces"_a = py::none(), "before"_a = py::none(), "See guided.partition_guided.");
  m.def(
      "_inside_regions",
      [](const KeptMesh& mesh, const Partition& part, const py::object& barriers, Job* job) {
        const std::vector<VertexPair> edges = read_pairs(barriers, "barriers");
        return call_here(job, [&](Job& j) { return inside_regions(mesh, part, edges, j); });
      },
      "mesh"_a, "partition"_a, "barriers"_a, "job"_a = py::none(), "See guided.inside_regions.");
}

void bind_search(py::module_& m) {
  py::class_<BoundSearch> search(m, "_BoundSearch", py::module_local(), "See BoundSearch in simplify/within.h.");
  py::class_<BoundSearch::Step>(search, "Step", py::module_local())
      .def_readonly("anew", &BoundSearch::Step::anew)
      .def_readonly("share", &BoundSearch::Step::share)
      .def_readonly("begin", &BoundSearch::Step::begin)
      .def_readonly("end", &BoundSearch::Step::end);
  search.def(py::init<double, bool>(), "allowed"_a, "anew"_a)
      .def("next", &BoundSearch::next)
      .def("take", &BoundSearch::take, "distance"_a)
      .def_property_readonly("tries", &BoundSearch::tries);
  py::class_<Stretch>(m, "_Stretch", py::module_local(), "Maps a job's progress to a share of it while it is entered.")
      .def(py::init<Job&, double, double>(), "job"_a, "begin"_a, "end"_a, py::keep_alive<1, 2>())
      .def("__enter__", [](Stretch& stretch) { stretch.enter(); })
      .def("__exit__", [](Stretch& stretch, const py::args&) { stretch.exit(); });
}

void bind_within(py::module_& m) {
  m.def(
      "_scan_distances",
      [](const KeptMesh& mesh, const Partition& part, const PolygonMesh& polygons, double enough, std::int32_t threads,
         std::int32_t block, Job* job) {
        const DistanceOptions options{.enough = enough, .threads = threads, .block = block};
        return owned(call(job, [&](Job& j) { return scan_distances(mesh, part, polygons, options, j); }));
      },
      "mesh"_a, "partition"_a, "polygons"_a, "enough"_a, "threads"_a, "block"_a, "job"_a = py::none(),
      "See within.scan_distances.");
  m.def(
      "_distances_to_triangles",
      [](const py::object& points, const py::object& corners) {
        const std::vector<Vec3> from = read_points(points, "points", "(K, 3)");
        const std::vector<Vec3> to = read_points(corners, "corners", "(3 K, 3)");
        if (to.size() != 3 * from.size()) throw InvalidInput("each point needs three corners");
        std::vector<double> distances(from.size());
        for (std::size_t k = 0; k < from.size(); ++k)
          distances[k] = distance_to_triangle(from[k], {to[3 * k], to[3 * k + 1], to[3 * k + 2]});
        return owned(std::move(distances));
      },
      "points"_a, "corners"_a, "(K,) The distance of each point from its triangle.");
  m.def(
      "_tightened",
      [](const KeptMesh& mesh, const Partition& part, double bound, const MeshingOptions& given) {
        return call_here(nullptr, [&](Job&) { return tightened(mesh, part, bound, given); });
      },
      "mesh"_a, "partition"_a, "bound"_a, "given"_a, "See tightened in simplify/within.h.");
}

}  // namespace

void bind_simplify(py::module_& m) {
  bind_edges(m);
  bind_openings(m);
  bind_constraints(m);
  bind_search(m);
  bind_within(m);
}

}  // namespace isimp::bindings
