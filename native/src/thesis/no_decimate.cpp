#include "hybrid.h"
#include "isimp/core/errors.h"

/// In place of decimate.cpp where OpenMesh was not there to build with.
namespace isimp {

Decimated decimate(const Surface& /*surface*/, double /*fraction*/, Job& /*job*/) {
  throw InvalidInput("method hybrid is not in this build: it was made without OpenMesh (libopenmesh-dev)");
}

}  // namespace isimp
