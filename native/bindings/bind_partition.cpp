// The Python class Partition, its options and the partition itself.
#include <pybind11/stl.h>

#include <array>
#include <optional>
#include <utility>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/partition/noise.h"
#include "isimp/partition/partition.h"
#include "kept_mesh.h"
#include "options.h"
#include "pickles.h"
#include "read_guides.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

// tuned bound
constexpr int kNoiseForBound = 4;  // deviations; a bound below that makes regions of noise

py::object given_or_none(bool given, double value) { return given ? py::object(py::float_(value)) : py::none(); }

bool is_bounded(const Partition& part) { return part.bound > 0; }

py::list warnings(const Partition& part) {
  py::list list;
  if (is_bounded(part) && part.bound < kNoiseForBound * part.noise)
    list.append(
        py::str("the bound is below {} times the noise of {:.3g}, so that many regions are made for noise alone; "
                "a larger bound, or cleaning the scan, saves them")
            .format(kNoiseForBound, part.noise));
  return list;
}

py::object regularity_of(const Partition& part) {
  if (!part.regularity) return py::none();
  const Regularity& r = *part.regularity;
  py::dict found("directions"_a = r.directions, "planes"_a = r.planes, "rms_added"_a = r.rms - r.rms_before,
                 "rms"_a = r.rms, "length"_a = r.length,
                 "snapped_to"_a = py::dict("level"_a = r.level, "upright"_a = r.upright, "slope"_a = r.slopes,
                                           "parallel"_a = r.parallel, "free"_a = r.free, "by_hand"_a = r.by_hand));
  const RegularAxes& a = r.axes;
  if (!part.curved.empty())
    found["axes"] = py::dict("upright"_a = a.upright, "level"_a = a.level, "parallel"_a = a.parallel, "free"_a = a.free,
                             "coaxial"_a = a.coaxial, "equal_radii"_a = a.equal_radii);
  return found;
}

const char* name_of(CurvedKind kind) {
  constexpr std::array kNames = {"plane", "cylinder", "cone", "sphere", "revolution", "extrusion"};
  return kNames[static_cast<std::size_t>(kind)];
}

py::tuple numbers(const Vec3& v) { return py::make_tuple(v[0], v[1], v[2]); }

/// A list of dicts: one for each patch that still has a cell.
py::list curved_of(const Partition& part) {
  std::vector<py::list> regions(part.curved.size());
  for (std::size_t r = 0; r < part.region_cell.size(); ++r)
    if (const std::int32_t p = part.region_cell[r].proxy; p != kNone) regions[p].append(r);
  std::vector<std::int64_t> faces(part.curved.size(), 0);
  for (std::size_t r = 0; r < part.region_cell.size(); ++r)
    if (const std::int32_t p = part.region_cell[r].proxy; p != kNone) faces[p] += part.region_sum[r].faces;
  py::list all;
  for (std::size_t p = 0; p < part.curved.size(); ++p) {
    const CurvedProxy& c = part.curved[p];
    if (regions[p].empty()) continue;
    py::list profile;
    for (std::size_t i = 0; i + 1 < c.profile.size(); i += 2)
      profile.append(py::make_tuple(c.profile[i], c.profile[i + 1]));
    all.append(py::dict("kind"_a = name_of(c.kind), "axis"_a = numbers(c.axis), "across"_a = numbers(c.across),
                        "point"_a = numbers(c.point), "radius"_a = c.radius, "slope"_a = c.slope, "profile"_a = profile,
                        "hollow"_a = c.side < 0, "full"_a = c.full, "span"_a = c.span, "segments"_a = c.segments,
                        "rings"_a = c.rings, "faces"_a = faces[p], "regions"_a = regions[p], "number"_a = p));
  }
  return all;
}

/// A patch as Python sees it: its values by name, as attributes and as of a dict.
struct CurvedView {
  py::dict values;
};

void bind_curved_proxy(py::module_& m) {
  py::class_<CurvedView> view(
      m, "CurvedProxy", py::module_local(),
      R"(A curved patch of a partition, cut into segments round its axis and rings along its profile.

kind: "cylinder", "cone", "sphere", "revolution" or "extrusion". axis: unit. point: on the axis, the centre of a sphere. radius:
of a cone at `point`, of a revolution and an extrusion the largest. slope: of a cone, growth of the radius along the axis.
profile: of a revolution, (rho, z) of its corners, z along the axis from `point`; of an extrusion, the places of its corners
along `across` and along the axis x `across`, from `point`. Segments of an extrusion are strips along its axis. hollow: the surface looks towards its axis. full: all the way round;
span: the angle of all segments, radians. faces: number of faces of the mesh. regions: its cells. number: its place among all
patches. Values are attributes, and items as of a dict.)");
  constexpr std::pair<const char*, const char*> kValues[] = {
      {"kind", "\"cylinder\", \"cone\", \"sphere\", \"revolution\" or \"extrusion\"."},
      {"axis", "Unit, a tuple of 3 numbers."},
      {"point", "On the axis; the centre of a sphere. Scene units."},
      {"radius", "Of a cone at `point`, of a revolution and an extrusion the largest. Scene units."},
      {"slope", "Of a cone: growth of the radius along the axis."},
      {"profile",
       "Of a revolution: (rho, z) of its corners, z along the axis from `point`. Of an extrusion: their places along "
       "`across` and along the axis x `across`, from `point`."},
      {"across", "Unit, square to the axis: where angles begin, and the first direction of an extrusion's profile."},
      {"hollow", "Whether the surface looks towards its axis."},
      {"full", "Whether the segments go all the way round."},
      {"span", "The angle of all segments, radians."},
      {"segments", "Cells round the axis; of an extrusion, along its profile."},
      {"rings", "Cells along the profile."},
      {"faces", "Number of faces of the mesh."},
      {"regions", "The cells, a list of regions."},
      {"number", "Its place among all patches."},
  };
  for (const auto& [name, doc] : kValues)
    view.def_property_readonly(
        name, [name = name](const CurvedView& self) -> py::object { return self.values[name]; }, doc);
  view.def("__getitem__",
           [](const CurvedView& self, const std::string& name) -> py::object { return self.values[name.c_str()]; })
      .def("keys", [](const CurvedView& self) { return self.values.attr("keys")(); })
      .def("__repr__", [](const CurvedView& self) {
        return py::str("<CurvedProxy: {}, radius {:.4g}, {} segments, {} rings>")
            .format(self.values["kind"], self.values["radius"], self.values["segments"], self.values["rings"]);
      });
}

py::dict partition_report_of(const Partition& part) {
  py::dict report("regions"_a = part.region_count(), "proxies_asked"_a = part.proxies_asked,
                  "proxies_needed"_a = part.proxies_needed, "parts_left_out"_a = part.parts_left_out,
                  "area_left_out"_a = part.area_left_out, "error"_a = part.error, "rounds"_a = part.history.size(),
                  "tolerance"_a = given_or_none(part.tolerance > 0, part.tolerance),
                  "noise"_a = given_or_none(part.tolerance > 0 || is_bounded(part), part.noise),
                  "distance_max"_a = given_or_none(is_bounded(part), part.distance_max), "snapped"_a = part.snapped,
                  "curved"_a = curved_of(part), "warnings"_a = warnings(part));
  if (part.regularity) report.attr("update")(regularity_of(part));
  return report;
}

py::array region_locked(const Partition& part) {
  py::array_t<bool> locked(part.region_count());
  for (std::int32_t r = 0; r < part.region_count(); ++r)
    locked.mutable_at(r) = !part.region_locked.empty() && part.region_locked[r] != 0;
  return locked;
}

py::array region_left_out(const Partition& part) {
  py::array_t<bool> left_out(part.region_count());
  for (std::int32_t r = 0; r < part.region_count(); ++r) left_out.mutable_at(r) = part.is_left_out(r);
  return left_out;
}

void bind_partition_result(py::module_& m) {
  py::class_<Partition>(m, "Partition", py::module_local(), "A surface split into R connected, near-planar regions.")
      .def_property_readonly("face_region", viewer<Partition>(&Partition::face_region),
                             "(F,) int32 in [0, R), by face of mesh.triangles; -1 where a speck was left out.")
      .def_property_readonly("region_seed", viewer<Partition>(&Partition::region_seed),
                             "(R,) int32: the region's face that is nearest to its proxy.")
      .def_property_readonly("region_normal", viewer<Partition>(&Partition::region_normal),
                             "(R, 3) float64: unit, the area-weighted mean; zero for a region without area; where a "
                             "plane is given (a bound, regularise, align_planes, round parts), that of the plane.")
      .def_property_readonly("region_locked", &region_locked,
                             "(R,) bool: whether a region is locked against edits; see lock_regions.")
      .def_property_readonly("region_left_out", &region_left_out,
                             "(R,) bool: whether no polygon is made of a region; see leave_out_regions.")
      .def_property_readonly("history", viewer<Partition>(&Partition::history),
                             "(rounds,) float64: the error after each round.")
      .def_readonly("error", &Partition::error,
                    "Sum of weight * area * |n_face - n|^2, scene units squared: n is the weighted mean normal of the "
                    "region, with a bound the normal of its plane; other planes (round parts, regularise, "
                    "align_planes) do not change it. Small patches that closed an opening have the weight 0 where the "
                    "number of regions is given.")
      .def_property_readonly("region_count", &Partition::region_count, "R.")
      .def_readonly("proxies_asked", &Partition::proxies_asked,
                    "The requested number, or R if the number was found; R is larger where parts need more.")
      .def_readonly("proxies_needed", &Partition::proxies_needed, "The least that the kept components need together.")
      .def_readonly("parts_left_out", &Partition::parts_left_out, "How many components have no region.")
      .def_readonly("area_left_out", &Partition::area_left_out, "Their share of the whole area.")
      .def_property_readonly(
          "tolerance", [](const Partition& part) { return given_or_none(part.tolerance > 0, part.tolerance); },
          "Tolerance at which the number of regions was found, scene units; None: the number was given.")
      .def_property_readonly(
          "noise",
          [](const Partition& part) { return given_or_none(part.tolerance > 0 || is_bounded(part), part.noise); },
          "Deviation of the noise with which it was found, given or estimated, scene units; None as above.")
      .def_property_readonly(
          "region_offset", viewer<Partition>(&Partition::region_offset),
          "(R,) float64 with a bound, or where planes are or were held: each region's plane is where "
          "region_normal @ x is this, x in the caller's coordinates; else empty.")
      .def_property_readonly(
          "region_held", viewer<Partition>(&Partition::region_held),
          "(R,) uint8: 1 where regularise snapped the plane, 2 where align_planes set it, 4 where it is of a cell of a "
          "round part: polygons keep to these. 3 where align_planes released it: neither held nor snapped. Else 0. "
          "Empty: all 0.")
      .def_property_readonly(
          "bound", [](const Partition& part) { return given_or_none(is_bounded(part), part.bound); },
          "The given bound, scene units; None without.")
      .def_property_readonly(
          "distance_max", [](const Partition& part) { return given_or_none(is_bounded(part), part.distance_max); },
          "With a bound: the largest distance of a vertex from its region's plane, scene units; else None.")
      .def_readonly("smooth", &Partition::smooth,
                    "PartitionOptions.smooth of the partition; 0 where another method made it.")
      .def_property_readonly(
          "metric", [](const Partition& part) { return name_of(kMetrics, part.metric); },
          "PartitionOptions.metric of the partition; 'normals' where another method made it.")
      .def_readonly(
          "snapped", &Partition::snapped,
          "Whether the number is that of the planes of the surface: the costs of merging have a significant gap there.")
      .def_property_readonly(
          "regularity", &regularity_of,
          "The result of regularise for the planes, a dict; it is in the report too. None without, or edited since.")
      .def_property_readonly(
          "curved",
          [](const Partition& part) {
            py::list all;
            for (const py::handle values : curved_of(part)) all.append(CurvedView{values.cast<py::dict>()});
            return all;
          },
          "The curved patches that have cells, as CurvedProxy; empty where PartitionOptions.curved was not set.")
      .def_property_readonly("report", &partition_report_of, "The numbers of this partition as a dict.")
      .def(py::pickle([](const Partition& self) { return state_of(self); }, &partition_from_state))
      .def("__repr__", [](const Partition& part) {
        return py::str("<Partition: {} regions of {} faces, error {:.6g}>")
            .format(part.region_count(), part.face_region.size(), part.error);
      });
}

}  // namespace

Guides read_guides(const std::optional<py::object>& weights, const std::optional<py::object>& barriers) {
  Guides guides;
  if (weights) guides.weights = read_numbers(*weights, "weights", "(F,)");
  if (weights && guides.weights.empty()) throw InvalidInput("weights is empty: give one for each face");
  if (barriers) guides.barriers = read_pairs(*barriers, "barriers");
  return guides;
}

void bind_partition(py::module_& m) {
  OptionsClass<PartitionOptions>(m, "PartitionOptions",
                                 "How to split a surface into regions. All fields are keywords.");
  bind_curved_proxy(m);
  bind_partition_result(m);
  m.def(
      "partition",
      [](const KeptMesh& mesh, PartitionOptions options, Job* job, const std::optional<py::object>& weights,
         const std::optional<py::object>& barriers) {
        const Constraints constraints{.guides = read_guides(weights, barriers)};
        return call(job, [&](Job& j) { return mesh.partitioner().run(options, constraints, j); });
      },
      "mesh"_a, "options"_a = PartitionOptions(), py::kw_only(), "job"_a = py::none(), "weights"_a = py::none(),
      "barriers"_a = py::none(),
      R"(Split a surface into connected, near-planar regions.

The number of regions is options.proxies, or follows from options.detail, options.tolerance or options.bound. No region is
empty, and each is connected. Every kept component gets at least the regions that its topology needs: 4 if it is closed,
else 1, but never more than its faces. If that needs more than `proxies`, there are more, and `proxies_needed` reports it.
The same mesh and options give the same partition bit for bit, on any number of threads.
weights: (F,) float32 or float64, at least 0, the largest in [1e-30, 1e30]. They multiply the areas of the faces, also in
`error`; the density of regions grows with their square root. barriers: (K, 2) integers, pairs of vertices: edges of the mesh
that no region crosses.
The mesh keeps intermediate results, so another number, detail or tolerance takes a fraction of the time of the first.
Raises InvalidInput (an option out of its range, a weight or barrier that can't be used) or Cancelled.
Cost: method 'hierarchy' O(F), the others O(iterations * F).
Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.)");
  m.def(
      "_noise",
      [](const KeptMesh& mesh, Job* job) {
        return call(job, [&](Job& j) { return estimate_noise(mesh, Threads(1), j); });
      },
      "mesh"_a, "job"_a = py::none(), "See isimp/partition/noise.h.");
  m.def(
      "_has_noise",
      [](const KeptMesh& mesh, Job* job) {
        return call(job, [&](Job& j) { return is_noisier(mesh, kScanNoise * mean_edge(mesh), j); });
      },
      "mesh"_a, "job"_a = py::none(), "Whether a mesh has the noise of a scan: see isimp/partition/noise.h.");
  m.def(
      "barrier_faces",
      [](const KeptMesh& mesh, const Partition& part) {
        return owned(call_here(nullptr, [&](Job&) { return separated_faces(Surface(mesh, part.guided)); }));
      },
      "mesh"_a, "part"_a,
      R"((K, 2) int32: faces of the mesh whose common edge is a barrier of the partition.

Edits treat such faces as no neighbours. Cost: O(F).)");
  m.def(
      "partition_from",
      [](const KeptMesh& mesh, const py::object& face_region, Job* job, const std::optional<py::object>& weights,
         const std::optional<py::object>& barriers, const Partition* before) {
        const std::vector<std::int32_t> labels = read_indices(face_region, "face_region", "(F,)");
        const Guides guides = read_guides(weights, barriers);
        return call(job, [&](Job& j) {
          const bool guided = !guides.weights.empty() || !guides.barriers.empty();
          Partition part = partition_from(guided ? Surface(mesh, guides, j) : Surface(mesh), labels, j);
          return before == nullptr ? std::move(part) : inherited(std::move(part), *before);
        });
      },
      "mesh"_a, "face_region"_a, py::kw_only(), "job"_a = py::none(), "weights"_a = py::none(),
      "barriers"_a = py::none(), "before"_a = py::none(),
      R"(A partition from given labels.

face_region: (F,) integers of at least 0, or -1 for a face in no region. A label that is not connected becomes one region
for each connected piece, numbered by first face. weights, barriers: as in partition. before: a partition whose regions are
unions of these regions; its bound, planes, locks and tolerance are kept. Raises InvalidInput or Cancelled.)");
}

}  // namespace isimp::bindings
