// Replaces the thesis's methods in a build without them.
#include <string>

#include "isimp/core/errors.h"
#include "isimp/thesis/thesis.h"

namespace isimp {

struct Thesis::Kept {};

Thesis::Thesis() = default;

Thesis::~Thesis() = default;

bool Thesis::is_built() { return false; }

void Thesis::check(const PartitionOptions& options) {
  const std::string only = " in this build, which was made with ISIMP_THESIS=OFF";
  if (options.method != Method::hierarchy) throw InvalidInput("method hierarchy is the only one" + only);
  if (options.backend != "cpu")
    throw InvalidInput("back end 'cpu' is the only one" + only + ", got '" + options.backend + "'");
}

Partition Thesis::by_number(const Surface& /*surface*/, const Hierarchy& /*hierarchy*/, const PartitionOptions& options,
                            Job& /*job*/) const {
  check(options);
  throw Error("method hierarchy was asked of the thesis's methods");
}

std::vector<std::string> backends() { return {"cpu"}; }

}  // namespace isimp
