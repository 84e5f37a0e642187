// The Python class Mesh, and the functions that clean it.
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <tuple>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/found_opening.h"
#include "isimp/mesh/mesh.h"
#include "isimp/simplify/openings.h"
#include "kept_mesh.h"
#include "options.h"
#include "pickles.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

py::dict mesh_report_of(const MeshReport& report) {
  py::dict all("vertices"_a = report.vertices, "faces"_a = report.faces, "components"_a = report.components,
               "closed_components"_a = report.closed_components, "border_edges"_a = report.border_edges,
               "border_loops"_a = report.border_loops, "euler"_a = report.euler,
               "zero_area_faces"_a = report.zero_area_faces, "unused_vertices"_a = report.unused_vertices,
               "area"_a = report.area, "diagonal"_a = report.diagonal, "closed"_a = report.closed,
               "cell"_a = report.cell);
  py::dict repairs, places;
  for (const Repair& repair : report.repairs) {
    const py::str key(repair.what);
    all[key] = repair.count;
    repairs[key] = repair.count;
    places[key] = repair.where;
  }
  all["repairs"] = repairs;
  all["repaired_at"] = places;
  return all;
}

std::shared_ptr<KeptMesh> make_mesh(const py::object& vertices, const py::object& triangles, Job* job,
                                    std::int32_t threads) {
  if (threads < 0) throw InvalidInput("threads must be at least 0, got " + std::to_string(threads));
  auto points = read_vertices(vertices, Threads(threads));
  auto corners = read_triangles(triangles, points.size());
  return call(
      job, [&](Job& j) { return std::make_shared<KeptMesh>(Mesh(std::move(points), std::move(corners), j, threads)); });
}

std::shared_ptr<KeptMesh> clean_mesh(const py::object& vertices, const py::object& triangles,
                                     const CleanOptions& options, Job* job, const py::object& keep) {
  auto points = read_vertices(vertices, Threads(options.threads));
  auto corners = read_triangles(triangles, points.size());
  const std::vector<Vec3> places = keep.is_none() ? std::vector<Vec3>() : read_points(keep, "keep", "(K, 3)");
  return call(job, [&, options](Job& j) {
    Cleaned cleaned = clean_keeping(std::move(points), std::move(corners), options, places, j);
    return std::make_shared<KeptMesh>(std::move(cleaned.mesh), std::move(cleaned.openings));
  });
}

std::shared_ptr<KeptMesh> close_mesh(const KeptMesh& mesh, const CleanOptions& options, Job* job,
                                     const py::object& keep, std::int32_t left_out) {
  const std::vector<Vec3> places = keep.is_none() ? std::vector<Vec3>() : read_points(keep, "keep", "(K, 3)");
  return call(job, [&, options](Job& j) {
    const auto aside = smallest_components(mesh, left_out, j);
    Cleaned cleaned = close_openings(mesh, options, places, j, aside);
    return std::make_shared<KeptMesh>(std::move(cleaned.mesh), std::move(cleaned.openings));
  });
}

py::list openings_of(const KeptMesh& mesh) {
  py::list all;
  for (const auto& [handle, kept, center, length, loops] : mesh.openings()) {
    py::list lines;
    for (const std::vector<Vec3>& loop : loops) lines.append(owned(std::vector<Vec3>(loop)));
    all.append(py::dict("kind"_a = handle ? "handle" : "hole", "kept"_a = kept,
                        "center"_a = py::make_tuple(center[0], center[1], center[2]), "length"_a = length,
                        "loops"_a = std::move(lines)));
  }
  return all;
}

void bind_class(py::module_& m) {
  py::class_<KeptMesh, std::shared_ptr<KeptMesh>>(m, "Mesh", py::module_local(),
                                                  R"(An oriented triangle surface, checked once and never changed.

Every edge has one or two faces that run along it in opposite directions, the faces at a vertex form one fan, all
coordinates are finite. Borders, several components, zero-area faces and unused vertices are ordinary.)")
      .def(py::init(&make_mesh), "vertices"_a, "triangles"_a, py::kw_only(), "job"_a = py::none(), "threads"_a = 0,
           R"(Check and copy the arrays.

vertices: (V, 3) float32 or float64, scene units. triangles: (F, 3) integers, counter-clockwise seen from outside.
threads: number of threads; 0: the number of cores. The result does not depend on it.
Raises InvalidInput, which names the first row that can't be used and why; `clean` repairs such arrays. Cost: O(V + F).)")
      .def_property_readonly("vertices", viewer<KeptMesh>(&KeptMesh::placed_vertices), "(V, 3) float64, read-only.")
      .def_property_readonly(
          "origin",
          [](const KeptMesh& mesh) {
            return std::tuple{mesh.origin()[0], mesh.origin()[1], mesh.origin()[2]};
          },
          "(x, y, z): the offset that the engine subtracts from coordinates that are large relative to the mesh, such "
          "as map coordinates; 0 along the other axes. The difference from `vertices` is exact. Results are in the "
          "caller's coordinates.")
      .def_property_readonly("triangles", viewer<KeptMesh>(&Mesh::triangles), "(F, 3) int32, read-only.")
      .def_property_readonly(
          "source_face", viewer<KeptMesh>(&Mesh::source_face),
          "(F,) int32: the caller's face of each face; the identity after Mesh(...); -1 for one that covers a hole.")
      .def_property_readonly("source_vertex", viewer<KeptMesh>(&Mesh::source_vertex),
                             "(V,) int32: the caller's vertex of each vertex; -1 for one that a repair made.")
      .def_property_readonly("component", viewer<KeptMesh>(&Mesh::component),
                             "(F,) int32: the component of each face, numbered by first face.")
      .def_property_readonly(
          "report", [](const KeptMesh& mesh) { return mesh_report_of(mesh.report()); },
          R"(Properties of the mesh, as a dict.

vertices, faces, components, closed_components, border_edges, border_loops, euler, zero_area_faces, unused_vertices,
area and diagonal (scene units), closed, cell (of the grid whose stair steps were smoothed, scene units; 0: none); after
`clean` also the count of each repair (unused_vertices: the number of dropped ones). `repairs` holds these counts alone,
`repaired_at` the caller's indices of the first few of each: vertices for the keys that end so, else faces; both are
empty after Mesh(...).)")
      .def_property_readonly("openings", &openings_of,
                             R"(The openings that `clean` was asked to close, as a list of dicts.

kind ('hole' or 'handle'), kept (True: it stayed open, since a place in `keep` selects it; False: it was closed), center
(x, y, z), length (of the border of a hole, of the loop around a handle or tunnel) and loops: (K, 3) arrays of closed
polylines, the border of a hole or both ends of the cut. In the caller's coordinates.)")
      .def(py::pickle([](const KeptMesh& self) { return state_of(self); }, &mesh_from))
      .def("__repr__", [](const KeptMesh& mesh) {
        const MeshReport& r = mesh.report();
        return py::str("<Mesh: {} faces, {} vertices, {} component{}, {}>")
            .format(r.faces, r.vertices, r.components, r.components == 1 ? "" : "s", r.closed ? "closed" : "open");
      });
}

}  // namespace

void bind_mesh(py::module_& m) {
  OptionsClass<CleanOptions>(m, "CleanOptions", "How to repair a mesh. All fields are keywords.");
  bind_class(m);
  m.def("clean", &clean_mesh, "vertices"_a, "triangles"_a, "options"_a = CleanOptions(), py::kw_only(),
        "job"_a = py::none(), "keep"_a = py::none(),
        R"(Repair any triangles into a Mesh: output of scanners, STL files, texture seams.

The repairs in their order. The mesh's report has the count and first places of each under this key:
 non_finite_faces      dropped: a coordinate is not finite
 repeated_index_faces  dropped: a vertex is used twice, in the input or after welding
 duplicate_faces       dropped: the same three vertices as an earlier face, in either orientation
 welded_vertices       border vertices at the same position become one
 flipped_faces         orientation reversed, so that each component is consistent; the smaller area yields
 cut_edges             cut open: no orientation fits both sides (a Moebius strip)
 split_edges           non-manifold edges (three or more faces), split
 split_vertices        vertices copied, once for each further fan of faces around them
 subdivided_edges      halved: two edges with the same ends remained
 turned_edges          edge flips: the longest edge of a zero-area face, so that it and its neighbour have an area
 unused_vertices       dropped: no kept face uses them
 stitched_vertices     border vertices that became one with another border, or were put into its edge
 inner_faces           dropped: their component is inside a closed one (CleanOptions.outside_only)
 smoothed_vertices     moved within half a cell of the grid of occupied cells that the mesh was cut on
 filled_holes          covered by new faces that intersect nothing where there are such, at most half of the component
 cut_handles           the ring of faces around a handle removed, both ends covered
Zero-area faces that no flip mends are kept. Faces and vertices keep the caller's order; copies and covers come last.
vertices: (V, 3) float32 or float64, any values. triangles: (F, 3) integers in [0, V).
keep: (K, 3) places whose holes and handles stay open, such as the centers in `Mesh.openings`: an opening stays if one
lies within a quarter of its length of its center.
Raises InvalidInput (another shape, no faces, an index out of range, a negative length, no face is left) or
Cancelled. Cost: O(V + F); closing holes or handles adds O((V + F) log F).)");
  m.def("close_openings", &close_mesh, "mesh"_a, "options"_a, py::kw_only(), "job"_a = py::none(),
        "keep"_a = py::none(), "left_out"_a = 0,
        R"(Close openings of a mesh that is repaired already.

The result is that of `clean` with these options for the arrays that the mesh was made from; its report covers both. The
other repairs are not repeated. `fill_holes`, `fill_flat_holes`, `cut_handles` and `threads` of the options count;
`opening_lengths` gives lengths. keep: see `clean`. left_out: so many components, the smallest ones, stay as they are and
come last, and the others do not depend on them; see `openings.Lengths`.
Raises InvalidInput (a negative length, a place that is not finite) or Cancelled. Cost: O((V + F) log F).)");
}

}  // namespace isimp::bindings
