#include "bindings.h"
#include "call.h"
#include "isimp/interact/interact.h"
#include "kept_mesh.h"
#include "options.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

using Edit = Partition (*)(const Mesh&, const Partition&, std::int32_t, Job&);

/// Edits take a few milliseconds, so they run on the caller's thread.
void bind_edit(py::module_& m, const char* name, Edit edit, const char* doc) {
  m.def(
      name,
      [edit](const KeptMesh& mesh, const Partition& part, const py::object& face, Job* job) {
        const auto index = static_cast<std::int32_t>(to_integer(face, "face", std::numeric_limits<std::int32_t>::min(),
                                                                std::numeric_limits<std::int32_t>::max()));
        Job own;
        const py::gil_scoped_release released;
        return edit(mesh, part, index, job != nullptr ? *job : own);
      },
      "mesh"_a, "partition"_a, "face"_a, "job"_a = py::none(), doc);
}

}  // namespace

void bind_interact(py::module_& m) {
  bind_edit(m, "add_proxy", &add_proxy, R"(Start a new region at a face: the thesis's `add`. Returns a new Partition.

face: index into mesh.triangles. The new region is the last one, all others keep their numbers; only the region of the
face and those around it change. A face of a part that was left out brings that part back as one region.
Raises InvalidInput (no such face, or its region is a single face) or Cancelled.)");
  bind_edit(m, "delete_proxy", &delete_proxy,
            R"(Take the region of a face away: the thesis's `del`. Returns a new Partition.

face: index into mesh.triangles. The regions around flood its faces; those above it move down by one number.
Raises InvalidInput (no such face, it was left out, or its region is the only one of its part) or Cancelled.)");
}

}  // namespace isimp::bindings
