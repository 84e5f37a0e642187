#include "hybrid.h"
#include "isimp/core/errors.h"

/// Replaces decimate.cpp in a build without OpenMesh.
namespace isimp {

Decimated decimate(const Surface& /*surface*/, double /*fraction*/, Job& /*job*/) {
  throw InvalidInput("method hybrid is not in this build: it was made without OpenMesh (libopenmesh-dev)");
}

}  // namespace isimp
