// The Python functions on curved patches: their cells, segments and surfaces.
#include <pybind11/stl.h>

#include <optional>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/curved/edit_round.h"
#include "kept_mesh.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

std::optional<CurvedKind> kind_of(const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  if (*name == "cylinder") return CurvedKind::cylinder;
  if (*name == "cone") return CurvedKind::cone;
  if (*name == "sphere") return CurvedKind::sphere;
  if (*name == "revolution") return CurvedKind::revolution;
  if (*name == "extrusion") return CurvedKind::extrusion;
  throw InvalidInput("kind must be 'cylinder', 'cone', 'sphere', 'revolution', 'extrusion' or None, got '" + *name +
                     "'");
}

}  // namespace

void bind_curved(py::module_& m) {
  m.def(
      "make_round",
      [](const KeptMesh& mesh, const Partition& part, const py::object& faces, const std::optional<std::string>& kind,
         Job* job) {
        const std::vector<std::int32_t> some = read_indices(faces, "faces", "(n,)");
        const std::optional<CurvedKind> wanted = kind_of(kind);
        return call(job, [&](Job& j) { return make_round(mesh, part, some, wanted, j); });
      },
      "mesh"_a, "part"_a, "faces"_a, "kind"_a = py::none(), py::kw_only(), "job"_a = py::none(),
      R"(Make the regions of some faces one curved patch of as many cells.

faces: (n,) integers, faces of the mesh. kind: 'cylinder', 'cone', 'sphere', 'revolution' or 'extrusion'; None: the
simplest that fits nearly as well as the best. All other regions stay. Raises InvalidInput (no face, one out of range, a locked region, faces
that determine no round surface) or Cancelled. Cost: O(F).)");
  m.def(
      "set_segments",
      [](const KeptMesh& mesh, const Partition& part, std::int32_t face, std::int32_t segments, std::int32_t rings,
         Job* job) { return call(job, [&](Job& j) { return with_segments(mesh, part, face, segments, rings, j); }); },
      "mesh"_a, "part"_a, "face"_a, "segments"_a, "rings"_a = 0, py::kw_only(), "job"_a = py::none(),
      R"(Cut the curved patch of a face into another number of segments and rings.

segments: in [3, 256] where the patch is closed around its axis, else in [1, 256], for an extrusion at most 120.
rings: in [0, 64]; 0: as many as keep about the number of cells; an extrusion has one.
All other regions stay. Raises InvalidInput (a face in no patch, a number out of range, a locked cell) or Cancelled.
Cost: O(F).)");
  m.def(
      "release_round",
      [](const KeptMesh& mesh, const Partition& part, std::int32_t face, Job* job) {
        return call_here(job, [&](Job& j) { return explode_round(mesh, part, face, j); });
      },
      "mesh"_a, "part"_a, "face"_a, py::kw_only(), "job"_a = py::none(),
      R"(Make the cells of the curved patch of a face ordinary regions: labels stay, planes are free.

Raises InvalidInput (a face in no patch, a locked cell) or Cancelled.)");
  m.def(
      "round_part_at",
      [](const KeptMesh& mesh, const Partition& part, std::int32_t face) -> std::optional<std::int32_t> {
        const std::int32_t patch = patch_of(mesh, part, face);
        return patch == kNone ? std::nullopt : std::optional(patch);
      },
      "mesh"_a, "part"_a, "face"_a,
      "The `number` of the curved patch that a face is in, None if in none. Raises InvalidInput if it is out of "
      "range.");
}

}  // namespace isimp::bindings
