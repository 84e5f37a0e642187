#include <memory>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/mesh/mesh.h"

namespace isimp::bindings {
namespace {

py::dict report_of(const MeshReport& report) {
  using namespace py::literals;
  py::dict repairs, where;
  for (const Repair& repair : report.repairs) {
    repairs[py::str(repair.what)] = repair.count;
    where[py::str(repair.what)] = repair.where;
  }
  return py::dict("vertices"_a = report.vertices, "faces"_a = report.faces, "components"_a = report.components,
                  "closed_components"_a = report.closed_components, "border_edges"_a = report.border_edges,
                  "border_loops"_a = report.border_loops, "euler"_a = report.euler,
                  "zero_area_faces"_a = report.zero_area_faces, "unused_vertices"_a = report.unused_vertices,
                  "area"_a = report.area, "diagonal"_a = report.diagonal, "closed"_a = report.closed,
                  "repairs"_a = repairs, "repaired_at"_a = where);
}

std::shared_ptr<Mesh> make_mesh(const py::object& vertices, const py::object& triangles, Job* job) {
  auto points = read_vertices(vertices);
  auto corners = read_triangles(triangles, points.size());
  return call(job, [&](Job& j) { return std::make_shared<Mesh>(std::move(points), std::move(corners), j); });
}

}  // namespace

void bind_mesh(py::module_& m) {
  using namespace py::literals;
  py::class_<Mesh, std::shared_ptr<Mesh>>(m, "Mesh", py::module_local(),
                                          R"(An oriented triangle surface, checked once and never changed.

Every edge has one or two faces that run along it in opposite directions, the faces round a vertex form one fan, all
coordinates are finite. Borders, several components, zero-area faces and unused vertices are ordinary.)")
      .def(py::init(&make_mesh), "vertices"_a, "triangles"_a, "job"_a = py::none(),
           R"(Check and copy the arrays.

vertices: (V, 3) float32 or float64, scene units. triangles: (F, 3) int32 or int64, counter-clockwise seen from outside.
Raises InvalidInput, which names the first row that can't be used and why; `clean` takes such arrays. Cost: O(V + F).)")
      .def_property_readonly("vertices", viewer(&Mesh::vertices), "(V, 3) float64, read-only.")
      .def_property_readonly("triangles", viewer(&Mesh::triangles), "(F, 3) int32, read-only.")
      .def_property_readonly("source_face", viewer(&Mesh::source_face),
                             "(F,) int32: the caller's face each face came from; the identity after Mesh(...).")
      .def_property_readonly("source_vertex", viewer(&Mesh::source_vertex),
                             "(V,) int32: the caller's vertex each vertex came from; -1 for one that a repair made.")
      .def_property_readonly("component", viewer(&Mesh::component),
                             "(F,) int32: the component of each face, numbered by first face.")
      .def_property_readonly(
          "report", [](const Mesh& mesh) { return report_of(mesh.report()); }, R"(What the mesh is.

vertices, faces, components, closed_components, border_edges, border_loops, euler, zero_area_faces, unused_vertices,
area and diagonal (scene units), closed; `repairs`: how often each repair was made, and `repaired_at`: the caller's
indices of the first few of each. Both are empty after Mesh(...).)")
      .def("__repr__", [](const Mesh& mesh) {
        const MeshReport& r = mesh.report();
        return py::str("<Mesh: {} faces, {} vertices, {} component{}, {}>")
            .format(r.faces, r.vertices, r.components, r.components == 1 ? "" : "s", r.closed ? "closed" : "open");
      });
}

}  // namespace isimp::bindings
