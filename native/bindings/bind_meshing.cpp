// The Python class PolygonMesh, and the functions that make polygons or set planes.
#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/mesh/io.h"
#include "isimp/meshing/expected.h"
#include "isimp/meshing/merge_flat.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/regular/align_planes.h"
#include "isimp/regular/hold_planes.h"
#include "isimp/regular/regularise.h"
#include "kept_mesh.h"
#include "options.h"
#include "pickles.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

const char* name_of(Defect kind) {
  switch (kind) {
    case Defect::crossing:
      return "crossing";
    case Defect::no_area:
      return "no_area";
    case Defect::flipped:
      return "flipped";
    case Defect::bent:
      return "bent";
    case Defect::intersecting:
      return "intersecting";
    case Defect::excused:
      break;
  }
  return "excused";
}

py::list listed_defects(const MeshingReport& r) {
  py::list list;
  for (const ListedDefect& i : r.imperfect) {
    py::dict entry("polygon"_a = i.polygon, "flaw"_a = name_of(i.kind));
    if (i.other >= 0) entry["other"] = i.other;
    list.append(entry);
  }
  return list;
}

py::dict meshing_report_of(const MeshingReport& r) {
  py::dict report(
      "polygons"_a = r.polygons, "corners"_a = r.corners, "vertices"_a = r.vertices, "regions"_a = r.regions,
      "regions_split"_a = r.regions_split, "merged_without_area"_a = r.merged_without_area,
      "joined_junctions"_a = r.joined_junctions, "split_for_unconnected"_a = r.split_for_unconnected,
      "split_for_holes"_a = r.split_for_holes, "split_for_handles"_a = r.split_for_handles,
      "split_for_pinches"_a = r.split_for_pinches, "split_for_closed"_a = r.split_for_closed,
      "split_for_repair"_a = r.split_for_repair, "closed"_a = r.closed, "manifold"_a = r.manifold, "euler"_a = r.euler,
      "planarity_max"_a = r.planarity_max, "planarity_mean"_a = r.planarity_mean, "distance_max"_a = r.distance_max,
      "crossing"_a = r.crossing, "flipped"_a = r.flipped, "bent"_a = r.bent, "intersecting"_a = r.intersecting,
      "excused"_a = r.excused, "excused_at_least"_a = r.excused_at_least, "without_area"_a = r.without_area,
      "repair_rounds"_a = r.repair_rounds, "repair_capped"_a = r.repair_capped,
      "work"_a = py::dict("faces"_a = r.work.faces, "corners"_a = r.work.corners, "polygons"_a = r.work.polygons),
      "imperfect"_a = listed_defects(r), "planes_let_go"_a = r.planes_let_go, "planar"_a = r.planar.planar,
      "rims"_a = py::dict("reach"_a = r.rims.reach, "edges"_a = r.rims.edges, "area_added"_a = r.rims.area_added,
                          "area_lost"_a = r.rims.area_lost),
      "boxes"_a = r.boxes, "concave"_a = r.concave, "cut_to_be_convex"_a = r.cut_to_be_convex);
  if (!r.planar.asked) return report;
  report["whole"] = r.planar.whole;
  report["left_off"] = r.planar.left_off;
  report["faces_added"] = r.planar.faces_added;
  report["faces_added_for"] =
      py::dict("apart"_a = r.planar.added_for_apart, "crossing"_a = r.planar.added_for_crossing,
               "flipped"_a = r.planar.added_for_flipped, "meeting"_a = r.planar.added_for_meeting);
  return report;
}

py::dict expectation(const ExpectedPolygons& e) {
  return py::dict("polygons"_a = e.polygons, "regions"_a = e.regions, "split_for_holes"_a = e.split_for_holes,
                  "split_for_handles"_a = e.split_for_handles, "split_for_closed"_a = e.split_for_closed,
                  "split_for_unconnected"_a = e.split_for_unconnected, "split_for_pinches"_a = e.split_for_pinches,
                  "split_for_repair"_a = e.split_for_repair);
}

void bind_polygon_mesh(py::module_& m) {
  py::class_<PolygonMesh>(m, "PolygonMesh", py::module_local(),
                          "A mesh of simple polygons without holes; polygon q has the corners "
                          "loops[loop_start[q] : loop_start[q + 1]], the last one the rest of `loops`.")
      .def_property_readonly("vertices", viewer<PolygonMesh>(&PolygonMesh::vertices), "(W, 3) float64, scene units.")
      .def_property_readonly("loops", viewer<PolygonMesh>(&PolygonMesh::loops),
                             "(L,) int32: the vertex of each corner.")
      .def_property_readonly("loop_start", viewer<PolygonMesh>(&PolygonMesh::loop_start),
                             "(Q,) int32: first corner of each polygon in `loops`.")
      .def_property_readonly("polygon_region", viewer<PolygonMesh>(&PolygonMesh::polygon_region),
                             "(Q,) int32: the region of each polygon.")
      .def_property_readonly("planarity", viewer<PolygonMesh>(&PolygonMesh::planarity),
                             "(Q,) float64: largest distance of a corner from the polygon's plane, scene units.")
      .def_property_readonly("source_vertex", viewer<PolygonMesh>(&PolygonMesh::source_vertex),
                             "(W,) int32: the vertex of the mesh that each one stands for.")
      .def_property_readonly("planes_let_go", viewer<PolygonMesh>(&PolygonMesh::planes_let_go),
                             "(K,) int32: the regions whose snapped plane the polygons do not use, rising: with it a "
                             "polygon would have a defect or, with options.planar, too many faces would be added.")
      .def_property_readonly(
          "report", [](const PolygonMesh& poly) { return meshing_report_of(poly.report); },
          R"(Properties of the polygons, as a dict.

polygons, corners, vertices, regions; regions_split (regions that became more than one polygon) and the causes;
closed, manifold, euler; planarity_max, planarity_mean (weighted by area) and distance_max (of a corner from its vertex),
scene units; crossing, flipped, bent: polygons with these defects; intersecting: pairs of polygons that intersect,
excused: such pairs whose regions intersect in the scan itself (excused_at_least: there are more, counting stopped);
without_area: polygons that are a face of the scan without area; repair_rounds; repair_capped: whether defects are left
whose repair would take more than options.repair_budget; work: numbers of faces walked over, corners placed and polygons judged, the same on every machine; imperfect: all of these by
polygon, of each kind the first 1,000;
planar: whether every polygon is planar to a millionth of the diagonal. With options.planar also whole, the share of the
polygons that were not cut; left_off: whether more would have been cut than options.planar_most allows, so that no polygon
was made planar; faces_added by cutting off corners, and faces_added_for, the causes: apart (planes do not meet
within reach), crossing, flipped, meeting (the polygon would have this defect). planes_let_go: the number of regions whose
snapped planes were released. rims: of straight rims the reach (0: rims follow the border), the edges at the rim, and the
area between them and the border of the scan: area_added and area_lost. concave: polygons with a corner beyond 180 degrees,
seen along their own normal; cut_to_be_convex: polygons added by options.convex. boxes: boxes that replace regions; their quads are
the last polygons, with the group's lowest region as polygon_region.
imperfect is a list of dicts with polygon (its index), flaw ("crossing", "no_area", "flipped", "bent", "intersecting" or
"excused") and, for the last two, other (the polygon it meets; each pair is listed under both; none for a face of the scan
without area).)")
      .def(
          "faces",
          [](const py::object& self) {
            const auto& poly = self.cast<const PolygonMesh&>();
            const py::object loops = self.attr("loops");
            py::list faces;
            for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
              faces.append(loops[py::slice(poly.loop_start[q], poly.loop_end(q), 1)]);
            }
            return faces;
          },
          "The corners of each polygon: a list of (K,) int32 indices into `vertices`.")
      .def(
          "triangles",
          [](const PolygonMesh& poly, Job* job) {
            const PolygonSoup soup{.vertices = poly.vertices,
                                   .loops = {poly.loops.begin(), poly.loops.end()},
                                   .loop_start = {poly.loop_start.begin(), poly.loop_start.end()}};
            return owned(call(job, [&](Job& j) { return triangulate(soup, j); }).triangles);
          },
          py::kw_only(), "job"_a = py::none(),
          "(T, 3) int32: the polygons cut into triangles, in order; see `triangulate`.")
      .def(py::pickle([](const PolygonMesh& self) { return state_of(self); }, &polygons_from))
      .def("__repr__", [](const PolygonMesh& poly) {
        return py::str("<PolygonMesh: {} polygons, {} vertices, {}>")
            .format(poly.polygon_count(), poly.vertices.size(), poly.report.closed ? "closed" : "open");
      });
}

}  // namespace

Align to_align(const std::string& to) {
  const std::pair<const char*, Align> names[] = {{"level", Align::level},       {"upright", Align::upright},
                                                 {"parallel", Align::parallel}, {"perpendicular", Align::perpendicular},
                                                 {"coplanar", Align::coplanar}, {"free", Align::free}};
  std::string all;
  for (const auto& [name, align] : names) {
    if (to == name) return align;
    all += (all.empty() ? "" : ", ") + std::string(name);
  }
  throw InvalidInput("to must be one of " + all + ", got '" + to + "'");
}

void bind_meshing(py::module_& m) {
  OptionsClass<MeshingOptions>(m, "MeshingOptions", "How to make polygons of regions. All fields are keywords.");
  OptionsClass<RegulariseOptions>(m, "RegulariseOptions",
                                  "How planes of regions are snapped. All fields are keywords.");
  bind_polygon_mesh(m);
  m.def(
      "regularise",
      [](const KeptMesh& mesh, const Partition& part, RegulariseOptions options, Job* job,
         const std::optional<py::object>& up_direction) {
        const auto up = up_direction ? std::optional(read_direction(*up_direction, "up_direction")) : std::nullopt;
        return call(job, [&](Job& j) { return regularise(mesh, part, options, j, up); });
      },
      "mesh"_a, "partition"_a, "options"_a = RegulariseOptions(), py::kw_only(), "job"_a = py::none(),
      "up_direction"_a = py::none(),
      R"(Snap the planes of regions: level, upright with right angles between them, equal slopes, parallel, coplanar.

The labels stay. The returned partition has region_normal, region_offset and region_held set, and polygonize uses these
planes. Its report has directions, planes and rms_added (scene units). An edit releases the planes of the regions that it
changes. Planes that align_planes has set stay, and lead. up_direction: (3,), in place of options.up.
Raises InvalidInput (the partition is not one of this mesh, or an option out of its range) or Cancelled.)");
  m.def(
      "_hold_planes",
      [](const KeptMesh& mesh, const Partition& part,
         const std::vector<std::tuple<std::int32_t, std::array<double, 3>, double>>& planes,
         const std::vector<std::tuple<std::int32_t, std::array<double, 3>, std::array<double, 3>, double>>& round,
         Job* job) {
        const auto vector = [](const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]); };
        std::vector<HeldPlane> held;
        for (const auto& [region, normal, offset] : planes) held.push_back({region, vector(normal), offset});
        std::vector<HeldRound> parts;
        for (const auto& [number, point, axis, radius] : round)
          parts.push_back({number, vector(point), vector(axis), radius});
        return call(job, [&](Job& j) { return hold_planes(mesh, part, held, parts, j); });
      },
      "mesh"_a, "partition"_a, "planes"_a, "parts"_a = py::list(), py::kw_only(), "job"_a = py::none(),
      R"(Hold planes and round parts at given places. Returns a new Partition, whose planes polygonize uses.

planes: (region, normal, offset) of each, normal * x = offset, normal of length 1 and facing as the region. parts: (number
in part.curved, point on the axis, axis, radius) of each; only full cylinders and spheres change their radius. Cells follow
their part. The labels stay; the bound is 0, as after an edit.
Raises InvalidInput (a number out of its range, a plane that is not finite, a region that was left out or is a cell of a
round part) or Cancelled.)");
  m.def(
      "merge_flat",
      [](const KeptMesh& mesh, double angle, const std::optional<py::object>& group, Job* job) {
        const auto groups = group ? read_indices(*group, "group", "(F,)") : std::vector<std::int32_t>();
        FlatMerge made = call(job, [&](Job& j) { return merge_flat(mesh, angle, groups, j); });
        return py::make_tuple(std::move(made.polygons), owned(std::move(made.face_region)));
      },
      "mesh"_a, "angle"_a = kFlatAngle, "group"_a = py::none(), py::kw_only(), "job"_a = py::none(),
      R"(Merge coplanar faces into polygons: a PolygonMesh, whose vertices are where they were, bit by bit, and (F,) int32, the
flat region of each face, as polygon_region numbers them.

Connected faces become one polygon if each lies in the plane of the others: its normal is within angle (degrees, in
[0, 90]) of that of the plane, or all its corners within a millionth of the diagonal. Vertices inside a polygon and on
straight borders are left out. A flat region with holes becomes several polygons. group: (F,) integers; faces of different
groups stay apart, as those of several materials.
Raises InvalidInput (an angle out of its range, not F groups) or Cancelled. Cost: O(F log F).)");
  m.def(
      "align_planes",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, const std::string& to,
         const py::object& up_direction, std::optional<double> length, Job* job) {
        const std::vector<std::int32_t> indices = read_indices(faces, "faces", "(K,)");
        const Align align = to_align(to);
        const Vec3 up = read_direction(up_direction, "up_direction");
        return call(job, [&](Job& j) { return align_planes(mesh, part, indices, align, up, length, j); });
      },
      "mesh"_a, "partition"_a, "faces"_a, "to"_a, "up_direction"_a = py::make_tuple(0.0, 0.0, 1.0),
      "length"_a = py::none(), py::kw_only(), "job"_a = py::none(),
      R"(Set the planes of the regions of some faces. Returns a new Partition, whose planes polygonize uses.

faces: (K,) integers, indices into mesh.triangles; the region of the first leads. to: "level", "upright", "parallel" or
"perpendicular" to the plane of the leading region, "coplanar" with it, or "free": not held any more. up_direction: (3,),
the upward direction. length: the largest increase of the root mean square distance of a region, scene units; None: 1 % of
the diagonal. The labels stay. An edit releases the planes of the regions whose area it changes by a fifth or more.
Raises InvalidInput (no face, one region where two are needed, a plane that adds more than length: the message names the
face and has the text "needs X, allowed Y") or Cancelled.)");
  m.def(
      "region_fits",
      [](const KeptMesh& mesh, const Partition& part) {
        const std::vector<RegionFit> fits = call(nullptr, [&](Job&) { return region_fits(mesh, part); });
        std::vector<Vec3> normal, centre;
        std::vector<double> area;
        py::array_t<double> spread({static_cast<py::ssize_t>(fits.size()), py::ssize_t{3}, py::ssize_t{3}});
        double* out = spread.mutable_data();
        for (const RegionFit& fit : fits) {
          normal.push_back(fit.normal);
          centre.push_back(fit.centre);
          area.push_back(fit.area);
          out = std::copy_n(fit.spread.data(), 9, out);  // it is symmetric
        }
        return py::make_tuple(owned(std::move(normal)), owned(std::move(centre)), spread, owned(std::move(area)));
      },
      "mesh"_a, "partition"_a,
      R"(The planes of best fit of all regions: (normal, centre, spread, area).

normal: (R, 3), of length 1. centre: (R, 3), on the plane, relative to mesh.origin. spread: (R, 3, 3), the covariance of
the surface around it. area: (R,), 0 where a region has no plane. To turn a plane about its centre to a normal n adds
sqrt(n @ spread @ n - normal @ spread @ normal) to the root mean square distance of its region. Cost: O(F).
Raises InvalidInput (the partition is not one of this mesh).)");
  m.def(
      "expected_polygons",
      [](const KeptMesh& mesh, const Partition& part, MeshingOptions options, Job* job) {
        return expectation(call(job, [&](Job& j) { return expected_polygons(mesh, part, options, j); }));
      },
      "mesh"_a, "partition"_a, "options"_a = MeshingOptions(), py::kw_only(), "job"_a = py::none(),
      R"(An estimate of the number of polygons that `polygonize` makes of a partition, with its causes, as a dict.

polygons, regions; split_for_holes, split_for_handles, split_for_closed, split_for_unconnected and split_for_pinches: the
polygons that the topology of the regions needs; split_for_repair: an estimate of the polygons for flatness and against
intersections. polygons is the sum of all others. Cost: about a fifth of `polygonize`. Error on scans: 3 % in the median.
Raises InvalidInput or Cancelled as `polygonize`.)");
  m.def(
      "polygonize",
      [](const KeptMesh& mesh, const Partition& part, MeshingOptions options, Job* job) {
        return call(job, [&](Job& j) { return polygonize(mesh, part, options, j); });
      },
      "mesh"_a, "partition"_a, "options"_a = MeshingOptions(), py::kw_only(), "job"_a = py::none(),
      R"(Turn the regions of a partition into polygons that meet edge to edge.

Raises InvalidInput (the partition is not one of this mesh, or an option out of its range) or Cancelled.
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 4.)");
}

}  // namespace isimp::bindings
