#include <pybind11/stl.h>

#include <array>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/tiles/thin.h"
#include "isimp/tiles/weld.h"
#include "kept_mesh.h"

/// All names here are private to the package, for tiles/tasks.py.
namespace isimp::bindings {

using namespace py::literals;

namespace {

using Numbers = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// The half-edges (3 face + corner) on the border of a mesh, rising.
std::vector<std::int32_t> border(const Mesh& mesh) {
  std::vector<std::int32_t> edges;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (mesh.opposite(h) == kNone) edges.push_back(h);
  return edges;
}

void bind_mesh_of_a_tile(py::module_& m) {
  m.def(
      "_tile_border",
      [](const KeptMesh& mesh) { return owned(call_here(nullptr, [&](Job&) { return border(mesh); })); }, "mesh"_a,
      "See isimp/tiles.");
  m.def(
      "_tile_thin",
      [](const KeptMesh& mesh, std::int64_t faces, Job* job) {
        tiles::Thinned t = call(job, [&](Job& j) { return tiles::thin(mesh, faces, j); });
        return py::make_tuple(owned(std::move(t.vertices)), owned(std::move(t.triangles)), owned(std::move(t.face)));
      },
      "mesh"_a, "faces"_a, "job"_a = py::none(), "See isimp/tiles/thin.h.");
}

void bind_welding(py::module_& m) {
  m.def(
      "_tile_weld",
      [](const py::object& points, const Numbers& tile, double length, Job* job) {
        const std::vector<Vec3> places = read_points(points, "points", "(N, 3)");
        if (tile.ndim() != 1) throw InvalidInput("tile must have one number for each point");
        const std::span<const std::int32_t> of(tile.data(), static_cast<std::size_t>(tile.size()));
        return owned(call(job, [&](Job& j) { return tiles::weld(places, of, length, j); }));
      },
      "points"_a, "tile"_a, "length"_a, "job"_a = py::none(), "See isimp/tiles/weld.h.");
  m.def(
      "_tile_points_on_edges",
      [](const py::object& ends, const py::object& points, double length, Job* job) {
        const std::vector<Vec3> edges = read_points(ends, "ends", "(2 E, 3)");
        const std::vector<Vec3> places = read_points(points, "points", "(N, 3)");
        const auto found = call(job, [&](Job& j) { return tiles::points_on_edges(edges, places, length, j); });
        std::vector<std::array<std::int32_t, 2>> pairs;
        for (const tiles::OnEdge& each : found) pairs.push_back({each.edge, each.point});
        return owned(std::move(pairs));
      },
      "ends"_a, "points"_a, "length"_a, "job"_a = py::none(), "See isimp/tiles/weld.h.");
}

}  // namespace

void bind_tiles(py::module_& m) {
  bind_mesh_of_a_tile(m);
  bind_welding(m);
}

}  // namespace isimp::bindings
