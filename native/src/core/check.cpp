#include "isimp/core/check.h"

namespace isimp::detail {

void fail_assertion(const char* what, const char* condition, const char* file, int line) {
  throw BrokenInvariant(std::string("internal check failed: ") + what + " (" + condition + ") at " + file + ":" +
                        std::to_string(line));
}

}  // namespace isimp::detail
