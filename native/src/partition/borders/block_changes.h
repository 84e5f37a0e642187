#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace isimp {

/// The changes of the regions by moves within one block: for each region the change of its sum, and its view from
/// within the block. Other blocks get the changes by take().
template <class Sum, class View>
class BlockChanges {
 public:
  /// \param views  (R) the views of the regions from outside
  explicit BlockChanges(const std::vector<View>& views) : outside_(views), views_(views), changes_(views.size()) {}

  [[nodiscard]] const View& view(std::int32_t region) const { return views_[region]; }
  /// The change and the view of a region that changes now; the caller updates both.
  std::pair<Sum&, View&> touch(std::int32_t region) {
    Change& change = changes_[region];
    if (!std::exchange(change.any, true)) changed_.push_back(region);
    return {change.sum, views_[region]};
  }
  /// The changes, which are then forgotten.
  std::vector<std::pair<std::int32_t, Sum>> take() {
    std::vector<std::pair<std::int32_t, Sum>> result;
    result.reserve(changed_.size());
    for (const std::int32_t region : changed_) {
      result.emplace_back(region, std::exchange(changes_[region], {}).sum);
      views_[region] = outside_[region];
    }
    changed_.clear();
    return result;
  }

 private:
  struct Change {
    Sum sum{};
    bool any = false;
  };
  const std::vector<View>& outside_;
  std::vector<View> views_;
  std::vector<Change> changes_;
  std::vector<std::int32_t> changed_;
};

}  // namespace isimp
