#include "pickles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "call.h"
#include "isimp/partition/soundness.h"
#include "packing.h"

// Structured bindings name all members, so that a new member does not compile until it is stored here.
namespace isimp::bindings {
namespace {

void check(bool fits) {
  if (!fits) refuse_pickle();
}

template <class Integers>
bool all_in(const Integers& items, std::int32_t low, std::size_t end) {
  return std::all_of(items.begin(), items.end(),
                     [&](std::int32_t i) { return i >= low && i < static_cast<std::int64_t>(end); });
}

constexpr std::size_t kAny =
    std::numeric_limits<std::uint32_t>::max();  // mark: for indices into arrays that are not in the
                                                // pickle

template <class... Numbers>
bool all_finite(Numbers... numbers) {
  return (std::isfinite(numbers) && ...);
}

bool all_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

bool all_finite(const std::vector<Vec3>& points) {
  return std::all_of(points.begin(), points.end(), [](const Vec3& v) { return v.allFinite(); });
}

/// Calls fn, which casts parts of a pickle.
/// \throws InvalidInput  one of them is of another type
template <class Function>
auto unpacked(Function fn) {
  try {
    return fn();
  } catch (const py::cast_error&) {
    refuse_pickle();
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    refuse_pickle();
  }
}

py::tuple pack_repairs(const RepairReport& repairs) {
  py::list list;
  for (const auto& [what, count, where] : repairs) list.append(py::make_tuple(what, count, pack(where)));
  return py::tuple(list);
}

RepairReport unpack_repairs(const py::tuple& packed) {
  RepairReport repairs;
  for (const py::handle item : packed) {
    const auto parts = item.cast<py::tuple>();
    check(parts.size() == 3);
    Repair repair{parts[0].cast<std::string>(), parts[1].cast<std::int64_t>(), {}};
    unpack(parts[2], repair.where);
    repairs.push_back(std::move(repair));
  }
  return repairs;
}

py::tuple pack_openings(const std::vector<FoundOpening>& openings) {
  py::list list;
  for (const auto& [handle, kept, center, length, loops] : openings) {
    py::list lines;
    for (const std::vector<Vec3>& loop : loops) lines.append(pack(loop));
    list.append(py::make_tuple(handle, kept, pack(std::vector<Vec3>{center}), length, py::tuple(lines)));
  }
  return py::tuple(list);
}

std::vector<FoundOpening> unpack_openings(const py::tuple& packed) {
  std::vector<FoundOpening> openings;
  for (const py::handle item : packed) {
    const auto parts = item.cast<py::tuple>();
    check(parts.size() == 5);
    FoundOpening& o = openings.emplace_back();
    std::vector<Vec3> center;
    unpack(parts[2], center);
    check(center.size() == 1);
    o = {parts[0].cast<bool>(), parts[1].cast<bool>(), center[0], parts[3].cast<double>(), {}};
    for (const py::handle line : parts[4].cast<py::tuple>()) unpack(line, o.loops.emplace_back());
    check(o.center.allFinite() && std::isfinite(o.length) &&
          std::all_of(o.loops.begin(), o.loops.end(), [](const auto& loop) { return all_finite(loop); }));
  }
  return openings;
}

py::object pack_guided(const std::shared_ptr<const GuidedGraph>& guided) {
  if (!guided) return py::none();
  const auto& [graph, weight, component, component_count] = *guided;
  const auto& [faces, neighbours, mesh_face, graph_face, area] = graph;
  return pack_all(weight, component, component_count, faces, neighbours, mesh_face, graph_face, area);
}

/// \param n  number of faces of the mesh
std::shared_ptr<const GuidedGraph> unpack_guided(const py::object& packed, std::size_t n) {
  if (packed.is_none()) return nullptr;
  auto guided = std::make_shared<GuidedGraph>();
  auto& [graph, weight, component, component_count] = *guided;
  auto& [faces, neighbours, mesh_face, graph_face, area] = graph;
  unpack_all(packed.cast<py::tuple>(), weight, component, component_count, faces, neighbours, mesh_face, graph_face,
             area);
  check(faces.size() == n + 1 && neighbours.size() == n + 1 && mesh_face.size() == n && graph_face.size() == n);
  check((weight.empty() || weight.size() == n) && (component.empty() || component.size() == n));
  check(all_in(mesh_face, 0, n) && all_in(graph_face, 0, n) && component_count >= 0 &&
        all_in(component, 0, static_cast<std::size_t>(component_count)));
  for (const auto& three : neighbours)
    for (const std::int32_t i : three) check(i >= 0 && i <= static_cast<std::int64_t>(n));
  for (std::size_t i = 0; i < n; ++i) check(graph_face[mesh_face[i]] == static_cast<std::int32_t>(i));
  const auto last = static_cast<std::int32_t>(n);
  for (std::int32_t i = 0; i < last; ++i)  // as often a neighbour of a face as it has that neighbour
    for (const std::int32_t j : neighbours[i])
      check(j == last || std::ranges::count(neighbours[i], j) == std::ranges::count(neighbours[j], i));
  for (const FaceRecord& f : faces) check(all_finite(f.nx, f.ny, f.nz, f.area) && f.area >= 0);
  check(std::all_of(weight.begin(), weight.end(), [](float w) { return std::isfinite(w) && w >= 0; }));
  check(std::isfinite(area) && component_count <= static_cast<std::int64_t>(n));
  return guided;
}

py::tuple pack_curved(const CurvedProxy& proxy) {
  const auto& [kind, point, axis, radius, slope, side, profile, closed, across] =
      static_cast<const CurvedSurface&>(proxy);
  const auto number = static_cast<std::int32_t>(kind);
  const std::vector<Vec3> places = {point, axis, across};
  return pack_all(number, places, radius, slope, side, profile, closed, proxy.phase, proxy.span, proxy.full,
                  proxy.segments, proxy.rings, proxy.knots, proxy.low_cap, proxy.high_cap);
}

CurvedProxy unpack_curved(const py::tuple& packed) {
  CurvedProxy p;
  std::int32_t kind = 0;
  std::vector<Vec3> places;
  unpack_all(packed, kind, places, p.radius, p.slope, p.side, p.profile, p.closed, p.phase, p.span, p.full, p.segments,
             p.rings, p.knots, p.low_cap, p.high_cap);
  check(kind >= 0 && kind <= static_cast<std::int32_t>(CurvedKind::extrusion) && places.size() == 3);
  p.kind = static_cast<CurvedKind>(kind);
  p.point = places[0];
  p.axis = places[1];
  p.across = places[2];
  return p;
}

py::tuple pack_report(const MeshingReport& report) {
  const auto& [polygons, corners, vertices, regions, regions_split, unconnected, holes, handles, pinches,
               closed_regions, repair, merged, joined, closed, manifold, euler, planarity_max, planarity_mean,
               distance_max, crossing, flipped, bent, intersecting, excused, excused_at_least, without_area, imperfect,
               rounds, work, capped, planar, concave, convex_cuts, rims, boxes, let_go] = report;
  const auto& [work_faces, work_corners, work_polygons] = work;
  const auto& [rim_reach, rim_edges, rim_added, rim_lost] = rims;
  const auto& [asked, is_planar, whole, added, apart, crossed, turned, meeting, left_off] = planar;
  return pack_all(polygons, corners, vertices, regions, regions_split, unconnected, holes, handles, pinches,
                  closed_regions, repair, merged, joined, closed, manifold, euler, planarity_max, planarity_mean,
                  distance_max, crossing, flipped, bent, intersecting, excused, excused_at_least, without_area,
                  imperfect, rounds, work_faces, work_corners, work_polygons, capped, asked, is_planar, whole, added,
                  apart, crossed, turned, meeting, left_off, rim_reach, rim_edges, rim_added, rim_lost, boxes, let_go,
                  concave, convex_cuts);
}

MeshingReport unpack_report(const py::tuple& packed) {
  MeshingReport report;
  auto& [polygons, corners, vertices, regions, regions_split, unconnected, holes, handles, pinches, closed_regions,
         repair, merged, joined, closed, manifold, euler, planarity_max, planarity_mean, distance_max, crossing,
         flipped, bent, intersecting, excused, excused_at_least, without_area, imperfect, rounds, work, capped, planar,
         concave, convex_cuts, rims, boxes, let_go] = report;
  auto& [work_faces, work_corners, work_polygons] = work;
  auto& [rim_reach, rim_edges, rim_added, rim_lost] = rims;
  auto& [asked, is_planar, whole, added, apart, crossed, turned, meeting, left_off] = planar;
  unpack_all(packed, polygons, corners, vertices, regions, regions_split, unconnected, holes, handles, pinches,
             closed_regions, repair, merged, joined, closed, manifold, euler, planarity_max, planarity_mean,
             distance_max, crossing, flipped, bent, intersecting, excused, excused_at_least, without_area, imperfect,
             rounds, work_faces, work_corners, work_polygons, capped, asked, is_planar, whole, added, apart, crossed,
             turned, meeting, left_off, rim_reach, rim_edges, rim_added, rim_lost, boxes, let_go, concave, convex_cuts);
  check(all_finite(planarity_max, planarity_mean, distance_max, whole, rim_reach, rim_added, rim_lost));
  for (const ListedDefect& i : imperfect)
    check(i.kind <= Defect::excused && i.polygon >= 0 && i.polygon < polygons && i.other >= kNone &&
          i.other < polygons);
  return report;
}

}  // namespace

py::tuple state_of(const KeptMesh& mesh) {
  const auto items = [](const auto span) { return pack(std::vector(span.begin(), span.end())); };
  // In the caller's coordinates: the mesh that is made from them is shifted by the same offset.
  return py::make_tuple(items(mesh.placed_vertices()), items(mesh.triangles()), items(mesh.source_face()),
                        items(mesh.source_vertex()), pack_repairs(mesh.report().repairs),
                        pack_openings(mesh.openings()), mesh.report().cell);
}

namespace {

std::shared_ptr<KeptMesh> mesh_of(const py::tuple& state) {
  check(state.size() == 7);
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  Array<std::int32_t> source_face, source_vertex;
  unpack_all(py::make_tuple(state[0], state[1], state[2], state[3]), vertices, triangles, source_face, source_vertex);
  check(source_face.size() == triangles.size() && source_vertex.size() == vertices.size());
  check(all_in(source_face, kNone, kAny) && all_in(source_vertex, kNone, kAny));
  RepairReport repairs = unpack_repairs(state[4].cast<py::tuple>());
  std::vector<FoundOpening> openings = unpack_openings(state[5].cast<py::tuple>());
  const auto cell = state[6].cast<double>();
  check(cell >= 0 && std::isfinite(cell));
  return call(nullptr, [&](Job& job) {
    return std::make_shared<KeptMesh>(Mesh(std::move(vertices), std::move(triangles), std::move(source_face),
                                           std::move(source_vertex), std::move(repairs), cell, Threads(0), job),
                                      std::move(openings));
  });
}

}  // namespace

std::shared_ptr<KeptMesh> mesh_from(const py::tuple& state) {
  return unpacked([&] { return mesh_of(state); });
}

py::tuple state_of(const Partition& partition) {
  const auto& [face_region, region_seed, region_normal, region_sum, error, history, smooth, off_planes, metric,
               tolerance, noise, snapped, bound, distance_max, region_offset, asked, needed, left_out, area_left_out,
               guided, locked, held, curved, cell, regularity] = partition;
  py::list patches;
  for (const CurvedProxy& proxy : curved) patches.append(pack_curved(proxy));
  const auto& [directions, planes, level, upright, slopes, parallel, free, by_hand, length, rms_before, rms, axes] =
      regularity.value_or(Regularity{});
  const auto& [axes_upright, axes_level, axes_parallel, axes_free, coaxial, equal_radii] = axes;
  return py::make_tuple(pack_all(face_region, region_seed, region_normal, region_sum, error, history, smooth, tolerance,
                                 noise, snapped, bound, distance_max, region_offset, asked, needed, left_out,
                                 area_left_out, locked, held, regularity.has_value(), directions, planes, level,
                                 upright, slopes, parallel, free, by_hand, length, rms_before, rms),
                        pack_guided(guided), py::tuple(patches), pack(cell),
                        pack_all(axes_upright, axes_level, axes_parallel, axes_free, coaxial, equal_radii),
                        pack_all(static_cast<std::int32_t>(metric), off_planes));
}

namespace {

/// The values of a partition without the ones of features that only older versions have: two counts of `regularise`, and
/// the plane of symmetry.
py::tuple without_gone(const py::tuple& values) {
  constexpr std::size_t kCounts = 28, kPlane = 33,
                        kBefore = 39;  // format: places of the first left-out values, and all values
  if (values.size() != kBefore) return values;
  py::list kept;
  for (std::size_t i = 0; i < kPlane; ++i)
    if (i < kCounts || i > kCounts + 1) kept.append(values[i]);
  return py::tuple(kept);
}

Partition partition_of(const py::tuple& state) {
  // Older versions have no curved patches, axes or metric.
  check(state.size() == 2 || (state.size() >= 4 && state.size() <= 6));
  Partition partition;
  auto& [face_region, region_seed, region_normal, region_sum, error, history, smooth, off_planes, metric, tolerance,
         noise, snapped, bound, distance_max, region_offset, asked, needed, left_out, area_left_out, guided, locked,
         held, curved, cell, regularity] = partition;
  Regularity found;
  auto& [directions, planes, level, upright, slopes, parallel, free, by_hand, length, rms_before, rms, axes] = found;
  bool is_regular = false;
  unpack_all(without_gone(state[0].cast<py::tuple>()), face_region, region_seed, region_normal, region_sum, error,
             history, smooth, tolerance, noise, snapped, bound, distance_max, region_offset, asked, needed, left_out,
             area_left_out, locked, held, is_regular, directions, planes, level, upright, slopes, parallel, free,
             by_hand, length, rms_before, rms);
  if (state.size() >= 5)
    unpack_all(state[4].cast<py::tuple>(), axes.upright, axes.level, axes.parallel, axes.free, axes.coaxial,
               axes.equal_radii);
  if (state.size() == 6) {
    std::int32_t number = 0;
    unpack_all(state[5].cast<py::tuple>(), number, off_planes);
    metric = static_cast<Metric>(number);
    check(metric == Metric::normals || metric == Metric::mixed || metric == Metric::distance);
  }
  if (is_regular) regularity = found;
  check(all_finite(error, smooth, off_planes, tolerance, noise, bound, distance_max, area_left_out) &&
        all_finite(history));
  check(!is_regular || all_finite(length, rms_before, rms));
  guided = unpack_guided(state[1], face_region.size());
  if (state.size() > 2) {
    for (const py::handle item : state[2].cast<py::tuple>()) curved.push_back(unpack_curved(item.cast<py::tuple>()));
    unpack(state[3], cell);
  }
  check(broken_arrays(partition).empty());
  return partition;
}

}  // namespace

Partition partition_from_state(const py::tuple& state) {
  return unpacked([&] { return partition_of(state); });
}

py::tuple state_of(const PolygonMesh& mesh) {
  const auto& [vertices, loops, loop_start, polygon_region, planarity, source_vertex, let_go, report] = mesh;
  return py::make_tuple(pack_all(vertices, loops, loop_start, polygon_region, planarity, source_vertex, let_go),
                        pack_report(report));
}

namespace {

PolygonMesh polygons_of(const py::tuple& state) {
  check(state.size() == 2);
  PolygonMesh mesh;
  auto& [vertices, loops, loop_start, polygon_region, planarity, source_vertex, let_go, report] = mesh;
  unpack_all(state[0].cast<py::tuple>(), vertices, loops, loop_start, polygon_region, planarity, source_vertex, let_go);
  check(polygon_region.size() == loop_start.size() && planarity.size() == loop_start.size());
  check(source_vertex.size() == vertices.size() && all_in(loops, 0, vertices.size()));
  check(all_in(source_vertex, kNone, kAny) && all_in(polygon_region, 0, kAny) && all_in(let_go, 0, kAny));
  check(all_in(loop_start, 0, loops.size() + 1) && std::is_sorted(loop_start.begin(), loop_start.end()));
  check(loop_start.empty() ? loops.empty() : loop_start.front() == 0);
  check(all_finite(vertices) && all_finite(planarity));
  report = unpack_report(state[1].cast<py::tuple>());
  check(report.polygons == mesh.polygon_count());
  return mesh;
}

}  // namespace

PolygonMesh polygons_from(const py::tuple& state) {
  return unpacked([&] { return polygons_of(state); });
}

}  // namespace isimp::bindings
