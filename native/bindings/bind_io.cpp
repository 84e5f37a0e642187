// The Python functions that read, triangulate and write files.
#include <pybind11/stl.h>

#include <optional>
#include <utility>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/polygonize.h"
#include "paths.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

void check_threads(std::int32_t threads) {
  if (threads < 0) throw InvalidInput("threads must be at least 0, got " + std::to_string(threads));
}

py::tuple read(const py::object& name, Job* job, std::int32_t threads) {
  const auto path = to_path(name);
  check_threads(threads);
  PolygonSoup soup;
  std::optional<Triangulation> cut;  // empty for the usual file: its corners are the triangles
  call(job, [&](Job& j) {
    soup = read_polygons(path, j, threads);
    if (!are_triangles(soup, j)) cut = triangulate(soup, j);
  });
  py::array triangles = cut ? owned(std::move(cut->triangles)) : owned(std::move(soup.loops)).reshape({-1, 3});
  return py::make_tuple(owned(std::move(soup.vertices)), std::move(triangles));
}

py::tuple read_as_polygons(const py::object& name, Job* job, std::int32_t threads) {
  const auto path = to_path(name);
  check_threads(threads);
  PolygonSoup soup = call(job, [&](Job& j) { return read_polygons(path, j, threads); });
  return py::make_tuple(owned(std::move(soup.vertices)), owned(std::move(soup.loops)),
                        owned(std::move(soup.loop_start)));
}

py::dict to_dict(std::vector<Column>&& columns) {
  py::dict result;
  for (Column& c : columns) result[py::str(c.name)] = owned(std::move(c.values)).attr("astype")(c.kind);
  return result;
}

/// Bytes that are no UTF-8 stay as os.fsdecode keeps them.
py::object to_text(const std::string& text) { return py::bytes(text).attr("decode")("utf-8", "surrogateescape"); }

py::tuple read_with_columns(const py::object& name, std::vector<std::string> names, Job* job, std::int32_t threads) {
  const auto path = to_path(name);
  check_threads(threads);
  Columns columns;
  columns.names = std::move(names);
  PolygonSoup soup = call(job, [&](Job& j) { return read_polygons(path, j, threads, &columns); });
  py::object uv = py::none();
  if (columns.uv) uv = owned(std::move(*columns.uv)).reshape({-1, 2});
  py::list files, materials, skipped;
  for (const std::string& file : columns.files) files.append(to_text(file));
  for (const auto& [face, material] : columns.materials) materials.append(py::make_tuple(face, to_text(material)));
  for (const std::string& what : columns.skipped) skipped.append(to_text(what));
  return py::make_tuple(owned(std::move(soup.vertices)), owned(std::move(soup.loops)),
                        owned(std::move(soup.loop_start)), to_dict(std::move(columns.vertices)),
                        to_dict(std::move(columns.faces)), uv, files, materials, skipped);
}

py::tuple cut(const py::object& vertices, const py::object& loops, const py::object& loop_start, Job* job) {
  const PolygonSoup soup = read_soup(vertices, loops, loop_start);
  Triangulation triangulation = call(job, [&](Job& j) { return triangulate(soup, j); });
  return py::make_tuple(owned(std::move(triangulation.triangles)), owned(std::move(triangulation.source_polygon)));
}

void write(const py::object& name, const PolygonMesh& poly, Job* job) {
  const auto path = to_path(name);
  call(job, [&](Job& j) { write_polygons(path, poly.vertices, poly.loops, poly.loop_start, j); });
}

}  // namespace

PolygonSoup read_soup(const py::object& vertices, const py::object& loops, const py::object& loop_start) {
  const auto corners = read_indices(loops, "loops", "(L,)"), starts = read_indices(loop_start, "loop_start", "(Q,)");
  PolygonSoup soup{read_vertices(vertices), {corners.begin(), corners.end()}, {starts.begin(), starts.end()}};
  soup.check();
  return soup;
}

void bind_io(py::module_& m) {
  m.def("read", &read, "path"_a, py::kw_only(), "job"_a = py::none(), "threads"_a = 0,
        R"(Read a mesh file; returns (vertices, triangles).

(V, 3) float64 and (F, 3) int32. PLY (text, binary), OBJ, STL (text, binary) or OFF, by the extension; polygons of more
corners are cut into triangles. Nothing is repaired; `clean` does that.
threads: number of threads; 0: the number of cores. The result does not depend on it.
Raises FileError, which names the file, the place in it and the expected content, or Cancelled.)");
  m.def("read_polygons", &read_as_polygons, "path"_a, py::kw_only(), "job"_a = py::none(), "threads"_a = 0,
        R"(Read a mesh file with its polygons; returns (vertices, loops, loop_start).

(V, 3) float64, (L,) int32, (Q,) int32: polygon q has the corners loops[loop_start[q] : loop_start[q + 1]], the last one
the rest of `loops`. Polygons keep the file's order and number, broken ones too. `threads` and errors as in `read`.)");
  m.def("_read_columns", &read_with_columns, "path"_a, "names"_a, "job"_a = py::none(), "threads"_a = 0);
  m.def("triangulate", &cut, "vertices"_a, "loops"_a, "loop_start"_a, py::kw_only(), "job"_a = py::none(),
        R"(Cut polygons into triangles without new vertices; returns (triangles, source_polygon).

(F, 3) int32 and (F,) int32, rising: the polygon of each triangle. A polygon of fewer than three corners gives none.
Raises InvalidInput (an index out of range) or Cancelled.)");
  m.def("write", &write, "path"_a, "polygons"_a, py::kw_only(), "job"_a = py::none(),
        R"(Write a PolygonMesh with its n-gons as PLY (binary) or OBJ, by the extension.

The file is replaced only when the new one is complete, and keeps its permissions. Pipes and devices are written in place.
Raises FileError (another extension, a file that is read-only, or the place can't be written) or Cancelled.)");
}

}  // namespace isimp::bindings
