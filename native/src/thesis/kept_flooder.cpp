#include "kept_flooder.h"

namespace isimp {

KeptFlooder::Loaded KeptFlooder::take(const Surface& surface, const std::string& backend) const {
  {
    const std::lock_guard lock(mutex_);
    Loaded kept = std::exchange(loaded_, {});
    if (kept.flooder && kept.backend == backend && kept.graph == &surface.graph()) return kept;
  }
  return {backend, surface.guided(), &surface.graph(), load(surface, backend)};
}

void KeptFlooder::keep(Loaded loaded) const {
  const std::lock_guard lock(mutex_);
  loaded_ = std::move(loaded);
}

}  // namespace isimp
