#include <pybind11/stl.h>

#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/core/to_integer.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/tiles/detail.h"
#include "isimp/tiles/merge.h"
#include "isimp/tiles/patches.h"
#include "isimp/tiles/relax.h"
#include "isimp/tiles/thin.h"
#include "isimp/tiles/weld.h"
#include "kept_mesh.h"
#include "options.h"

/// All names here are private to the package: tiles/steps.py has the public names and texts.
namespace isimp::bindings {

using namespace py::literals;

namespace {

template <class T>
using Table = py::array_t<T, py::array::c_style | py::array::forcecast>;
using Price = std::tuple<double, double, std::int32_t, double>;  ///< smooth, error, proxies, area
/// WholeScan of tiles/steps.py: error, area, faces, regions, smooth, sweeps.
using WholeScan = std::tuple<double, double, std::int64_t, std::int32_t, double, std::int32_t>;
constexpr py::ssize_t kSumColumns = 5, kMomentColumns = 10;

/// The rows of a table without a copy, as a struct of its numbers.
template <class Row, class T>
std::span<const Row> rows(const Table<T>& table, const char* name) {
  constexpr auto columns = static_cast<py::ssize_t>(sizeof(Row) / sizeof(T));
  const bool fits = columns == 1 ? table.ndim() == 1 : table.ndim() == 2 && table.shape(1) == columns;
  if (!fits) throw InvalidInput(std::string(name) + " must have " + std::to_string(columns) + " numbers in each row");
  return {reinterpret_cast<const Row*>(table.data()), static_cast<std::size_t>(table.shape(0))};
}

template <class Row, class Fill>
py::array_t<double> table_of(const std::vector<Row>& items, py::ssize_t columns, Fill fill) {
  py::array_t<double> table({static_cast<py::ssize_t>(items.size()), columns});
  double* at = table.mutable_data();
  for (const Row& item : items) {
    fill(item, at);
    at += columns;
  }
  return table;
}

void put(const RegionSum& s, double* at) {
  at[0] = s.x;
  at[1] = s.y;
  at[2] = s.z;
  at[3] = s.weight;
  at[4] = s.faces;
}

std::vector<RegionSum> read_sums(const Table<double>& table) {
  std::vector<RegionSum> sums;
  for (const auto& row : rows<std::array<double, kSumColumns>>(table, "sums"))
    sums.push_back(
        {row[0], row[1], row[2], row[3], isimp::to_integer(row[4], 0, std::numeric_limits<std::int32_t>::max())});
  return sums;
}

std::vector<SurfaceMoments> read_moments(const std::optional<Table<double>>& table, const Vec3& origin) {
  std::vector<SurfaceMoments> moments;
  if (!table) return moments;
  const auto given = rows<std::array<double, kMomentColumns>>(*table, "moments");
  moments.reserve(given.size());
  for (const auto& row : given) {
    SurfaceMoments m;
    m.area = row[0];
    m.centre = Vec3(row[1], row[2], row[3]) - origin;
    std::copy(row.begin() + 4, row.end(), m.second.begin());
    moments.push_back(m);
  }
  return moments;
}

void put_moments(const SurfaceMoments& m, double* at) {
  at[0] = m.area;
  for (int k = 0; k < 3; ++k) at[1 + k] = m.centre[k];
  std::copy(m.second.begin(), m.second.end(), at + 4);
}

tiles::JoinedGraph read_graph(const Table<double>& sums, const Table<std::int32_t>& pairs,
                              const Table<double>& lengths) {
  const auto pair = rows<std::array<std::int32_t, 2>>(pairs, "pairs");
  const auto length = rows<double>(lengths, "lengths");
  return {read_sums(sums), {pair.begin(), pair.end()}, {length.begin(), length.end()}};
}

/// The arrays of a mesh that relaxing needs.
py::tuple faces_of(const KeptMesh& mesh) {
  const FaceGraph& graph = mesh.graph();
  const py::ssize_t n = graph.size();
  py::array_t<float> record({n, py::ssize_t{4}}), length({n, py::ssize_t{3}});
  py::array_t<std::int32_t> neighbour({n, py::ssize_t{3}}), mesh_face(n);
  const auto p = mesh.vertices();
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const FaceRecord& f = graph.faces[i];
    float* at = record.mutable_data(i, 0);
    at[0] = f.nx;
    at[1] = f.ny;
    at[2] = f.nz;
    at[3] = static_cast<float>(f.area * graph.area);
    const Triangle& t = mesh.triangles()[graph.mesh_face[i]];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = graph.neighbours[i][k];
      *neighbour.mutable_data(i, k) = j == graph.size() ? kNone : j;
      *length.mutable_data(i, k) = static_cast<float>((p[t[(k + 1) % 3]] - p[t[k]]).norm());
    }
  }
  if (n > 0) std::memcpy(mesh_face.mutable_data(), graph.mesh_face.data(), sizeof(std::int32_t) * n);
  return py::make_tuple(record, neighbour, mesh_face, length);
}

tiles::JoinedComponents read_components(const Table<std::int32_t>& component, const Table<std::int32_t>& need) {
  tiles::JoinedComponents c;
  const auto of = rows<std::int32_t>(component, "component"), least = rows<std::int32_t>(need, "need");
  c.component.assign(of.begin(), of.end());
  c.need.assign(least.begin(), least.end());
  return c;
}

py::tuple tuple_of(tiles::Patches p) {
  py::array sums = table_of(p.sum, kSumColumns, put);
  return py::make_tuple(owned(std::move(p.label)), sums, owned(std::move(p.pair)), owned(std::move(p.length)));
}

void bind_patches(py::module_& m) {
  m.def("_tile_faces", &faces_of, "mesh"_a, "See tiles.faces_of.");
  m.def(
      "_tile_patches",
      [](const KeptMesh& mesh, std::int32_t size, double smooth, Job* job) {
        return tuple_of(call(job, [&](Job& j) { return tiles::patches(mesh, size, smooth, j); }));
      },
      "mesh"_a, "size"_a, "smooth"_a, "job"_a = py::none(), "See tiles.patches.");
}

void bind_detail(py::module_& m) {
  m.def(
      "_tile_measure",
      [](const KeptMesh& mesh, Job* job) {
        const tiles::Extent e = call(job, [&](Job& j) { return tiles::measure(mesh, j); });
        return py::make_tuple(e.area, std::array{e.centre.x(), e.centre.y(), e.centre.z()}, e.spread, e.noise);
      },
      "mesh"_a, "job"_a = py::none(), "See tiles.measure.");
  m.def(
      "_tile_detail_patches",
      [](const KeptMesh& mesh, double tolerance, double noise, Job* job) {
        return tuple_of(call(job, [&](Job& j) { return tiles::detail_patches(mesh, tolerance, noise, j); }));
      },
      "mesh"_a, "tolerance"_a, "noise"_a, "job"_a = py::none(), "See tiles.detail_patches.");
  m.def("_tile_least_cost", &tiles::least_cost, "tolerance"_a, "noise"_a, "See tiles.least_cost.");
  m.def(
      "_tile_find_regions",
      [](const Table<double>& sums, const Table<std::int32_t>& pairs, const Table<std::int32_t>& component,
         const Table<std::int32_t>& need, double tolerance, double noise, bool snap, std::optional<double> cost,
         Job* job) {
        const auto pair = rows<std::array<std::int32_t, 2>>(pairs, "pairs");
        const tiles::JoinedGraph graph{read_sums(sums), {pair.begin(), pair.end()}, {}};
        const tiles::JoinedComponents c = read_components(component, need);
        const tiles::FoundRegions found =
            call(job, [&](Job& j) { return tiles::find_regions(graph, c, tolerance, noise, snap, cost, j); });
        return py::make_tuple(found.regions, found.cost, found.snapped);
      },
      "sums"_a, "pairs"_a, "component"_a, "need"_a, "tolerance"_a, "noise"_a, "snap"_a, "cost"_a = py::none(),
      "job"_a = py::none(), "See tiles.find_regions.");
}

void bind_merging(py::module_& m) {
  m.def(
      "_tile_components",
      [](const Table<double>& sums, const Table<std::int32_t>& pairs, const Table<double>& lengths,
         const Table<std::uint8_t>& open, std::int32_t proxies, double leave_out) {
        tiles::JoinedComponents c = tiles::find_components(read_graph(sums, pairs, lengths),
                                                           rows<std::uint8_t>(open, "open"), proxies, leave_out);
        return py::make_tuple(owned(std::move(c.component)), owned(std::move(c.need)), c.left_out, c.area_left_out);
      },
      "sums"_a, "pairs"_a, "lengths"_a, "open"_a, "proxies"_a, "leave_out"_a, "See tiles.find_components.");
  m.def(
      "_tile_merge",
      [](const Table<double>& sums, const Table<std::int32_t>& pairs, const Table<double>& lengths,
         const Table<std::int32_t>& component, const Table<std::int32_t>& need, std::int32_t target, double smooth,
         double error, std::int32_t proxies, Job* job) {
        const auto graph = read_graph(sums, pairs, lengths);
        const tiles::JoinedComponents c = read_components(component, need);
        return owned(call(job, [&](Job& j) { return tiles::merge(graph, c, target, {smooth, error, proxies}, j); }));
      },
      "sums"_a, "pairs"_a, "lengths"_a, "component"_a, "need"_a, "target"_a, "smooth"_a, "error"_a, "proxies"_a,
      "job"_a = py::none(), "See tiles.merge.");
  m.def(
      "_tile_merge_inside",
      [](const Table<double>& sums, const Table<std::int32_t>& pairs, const Table<double>& lengths,
         const Table<std::int32_t>& component, const Table<std::int32_t>& need, const Table<std::uint8_t>& border,
         std::int32_t target, double limit, const Price& weight, Job* job) {
        const auto graph = read_graph(sums, pairs, lengths);
        const tiles::JoinedComponents c = read_components(component, need);
        const auto at_border = rows<std::uint8_t>(border, "border");
        const auto& [smooth, error, proxies, area] = weight;
        const tiles::BorderPrice price{smooth, error, proxies, area};
        tiles::GroupMerges made =
            call(job, [&](Job& j) { return tiles::merge_inside(graph, c, at_border, target, limit, price, j); });
        return py::make_tuple(owned(std::move(made.merged)), owned(std::move(made.price)));
      },
      "sums"_a, "pairs"_a, "lengths"_a, "component"_a, "need"_a, "border"_a, "target"_a, "limit"_a, "price"_a,
      "job"_a = py::none(), "See tiles.merge_inside.");
}

void bind_relaxing(py::module_& m) {
  m.def(
      "_tile_relax",
      [](const Table<float>& record, const Table<std::int32_t>& neighbour, std::int32_t owned_faces,
         const Table<std::int32_t>& label, const Table<std::uint8_t>& frozen, const Table<double>& sums,
         const WholeScan& whole, Job* job) {
        const tiles::TileFaces tile{rows<FaceRecord>(record, "faces"),
                                    rows<std::array<std::int32_t, 3>>(neighbour, "neighbours"), owned_faces};
        const auto labels = rows<std::int32_t>(label, "labels");
        const auto stays = rows<std::uint8_t>(frozen, "frozen");
        const std::vector<RegionSum> sum = read_sums(sums);
        const auto& [error, area, faces, regions, smooth, sweeps] = whole;
        const tiles::RelaxOptions options{error, smooth, area, faces, regions, sweeps};
        tiles::Relaxed r = call(job, [&](Job& j) { return tiles::relax(tile, labels, stays, sum, options, j); });
        std::vector<std::int32_t> changed;
        for (const auto& [region, unused] : r.change) changed.push_back(region);
        py::array change = table_of(r.change, kSumColumns, [](const auto& c, double* at) { put(c.second, at); });
        return py::make_tuple(owned(std::move(r.label)), owned(std::move(changed)), change, r.moves);
      },
      "faces"_a, "neighbours"_a, "owned"_a, "labels"_a, "frozen"_a, "sums"_a, "whole"_a, "job"_a = py::none(),
      "See tiles.relax.");
  m.def(
      "_tile_touching",
      [](const Table<std::int32_t>& neighbour, std::int32_t owned_faces, const Table<std::int32_t>& label,
         const Table<float>& length) {
        const tiles::TileFaces tile{{}, rows<std::array<std::int32_t, 3>>(neighbour, "neighbours"), owned_faces};
        tiles::Touching t =
            tiles::touching(tile, rows<std::int32_t>(label, "labels"), rows<std::array<float, 3>>(length, "lengths"));
        return py::make_tuple(owned(std::move(t.pair)), owned(std::move(t.length)));
      },
      "neighbours"_a, "owned"_a, "labels"_a, "lengths"_a, "See tiles.touching.");
}

void bind_thinning(py::module_& m) {
  m.def(
      "_tile_thin",
      [](const KeptMesh& mesh, const Table<std::int32_t>& label, const std::optional<Table<double>>& moments,
         Job* job) {
        const auto labels = rows<std::int32_t>(label, "labels");
        std::vector<SurfaceMoments> given = read_moments(moments, Vec3::Zero());
        tiles::Thinned t = call(job, [&](Job& j) { return tiles::thin(mesh, labels, given, j); });
        std::vector<SurfaceMoments>().swap(given);  // before there is one more copy
        py::array of_faces = table_of(t.moments, kMomentColumns, put_moments);
        return py::make_tuple(owned(std::move(t.vertices)), owned(std::move(t.triangles)), owned(std::move(t.label)),
                              of_faces);
      },
      "mesh"_a, "labels"_a, "moments"_a = py::none(), "job"_a = py::none(), "See tiles.thin.");
  py::class_<KeptMoments>(m, "_Moments", py::module_local(),
                          "Moments of the faces of a mesh, as polygonize_thinned takes them.");
  m.def(
      "_tile_keep_moments",
      [](const KeptMesh& mesh, const Table<double>& moments) {
        return KeptMoments{read_moments(moments, mesh.origin())};
      },
      "mesh"_a, "moments"_a, "See tiles.kept_moments.");
  m.def(
      "_tile_polygonize",
      [](const KeptMesh& mesh, const Partition& part, MeshingOptions options, const KeptMoments& moments, Job* job) {
        return call(job, [&](Job& j) { return polygonize(mesh, part, options, j, moments.of_face); });
      },
      "mesh"_a, "partition"_a, "options"_a, "moments"_a, "job"_a = py::none(), "See tiles.polygonize_thinned.");
}

void bind_welding(py::module_& m) {
  m.def(
      "_tile_weld",
      [](const py::object& points, const Table<std::int32_t>& tile, double length, Job* job) {
        const std::vector<Vec3> places = read_points(points, "points", "(N, 3)");
        const auto of = rows<std::int32_t>(tile, "tile");
        return owned(call(job, [&](Job& j) { return tiles::weld(places, of, length, j); }));
      },
      "points"_a, "tile"_a, "length"_a, "job"_a = py::none(), "See tiles.weld.");
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
      "ends"_a, "points"_a, "length"_a, "job"_a = py::none(), "See tiles.points_on_edges.");
}

}  // namespace

void bind_tiles(py::module_& m) {
  bind_patches(m);
  bind_detail(m);
  bind_merging(m);
  bind_relaxing(m);
  bind_thinning(m);
  bind_welding(m);
}

}  // namespace isimp::bindings
