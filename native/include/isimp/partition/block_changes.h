#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace isimp {

/// What moves within one block have changed of the regions: of each the change of its sum, and how it looks meanwhile
/// from within the block. Other blocks hear of it when it is taken.
template <class Sum, class View>
class BlockChanges {
 public:
  struct Seen {
    Sum change{};
    View view{};
    bool changed = false;
  };

  explicit BlockChanges(std::size_t regions) : seen_(regions) {}

  [[nodiscard]] const Seen& operator[](std::int32_t region) const { return seen_[region]; }
  /// For a region that changes now. \return its place; `changed` tells whether it had changed before
  std::pair<Seen&, bool> touch(std::int32_t region) {
    Seen& seen = seen_[region];
    const bool before = std::exchange(seen.changed, true);
    if (!before) changed_.push_back(region);
    return {seen, before};
  }
  /// The changes, which are then forgotten.
  std::vector<std::pair<std::int32_t, Sum>> take() {
    std::vector<std::pair<std::int32_t, Sum>> result;
    result.reserve(changed_.size());
    for (const std::int32_t region : changed_) result.emplace_back(region, std::exchange(seen_[region], {}).change);
    changed_.clear();
    return result;
  }

 private:
  std::vector<Seen> seen_;
  std::vector<std::int32_t> changed_;
};

}  // namespace isimp
