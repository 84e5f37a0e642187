#include "pieces.h"

#include <algorithm>
#include <utility>

#include "isimp/core/check.h"

namespace isimp {
namespace {

constexpr std::int32_t kFirstMark =
    -16;  // mark: mark of walk 0, below all labels with a meaning; the marks of other walks
          // follow

class Walks {
 public:
  Walks(const FaceGraph& graph, EditLabels labels, std::int32_t region)
      : graph_(graph), labels_(labels), region_(region) {}

  void start(std::int32_t face) {
    if (labels_.get(face) != region_) return;  // named twice
    const auto w = static_cast<std::int32_t>(walks_.size());
    walks_.push_back({{face}, {face}, w});
    labels_.set(face, kFirstMark - w);
    ++under_way_;
  }

  void run() {
    while (under_way_ > 1)
      for (std::size_t w = 0; w < walks_.size() && under_way_ > 1; ++w) {
        if (walks_[w].into != static_cast<std::int32_t>(w) || walks_[w].done) continue;
        if (!walks_[w].ahead.empty()) {
          step(static_cast<std::int32_t>(w));
        } else {
          walks_[w].done = true;
          --under_way_;
        }
      }
  }

  /// Restores the labels of the faces.
  /// \return the faces of walks that ended
  std::vector<std::int32_t> close() {
    std::vector<std::int32_t> cut;
    for (const Walk& walk : walks_) {
      for (const std::int32_t face : walk.faces) labels_.set(face, region_);
      if (walk.done) cut.insert(cut.end(), walk.faces.begin(), walk.faces.end());
    }
    return cut;
  }

 private:
  struct Walk {
    std::vector<std::int32_t> faces, ahead;  // all its faces, and the faces that it has not continued from
    std::int32_t into;                       // itself, or the walk it has become part of
    bool done = false;
  };

  std::int32_t root(std::int32_t w) const {
    while (walks_[w].into != w) w = walks_[w].into;
    return w;
  }

  void step(std::int32_t w) {
    const std::int32_t face = walks_[w].ahead.back();
    walks_[w].ahead.pop_back();
    for (const std::int32_t j : graph_.neighbours[face]) {
      const std::int32_t label = labels_.get(j);
      if (label == region_) {
        labels_.set(j, kFirstMark - w);
        walks_[w].faces.push_back(j);
        walks_[w].ahead.push_back(j);
      } else if (label <= kFirstMark) {
        w = join(w, root(kFirstMark - label));
      }
    }
  }

  /// Merges two walks.
  /// \return the one that continues: the one with more faces, since these need not be moved
  std::int32_t join(std::int32_t a, std::int32_t b) {
    if (a == b) return a;
    if (walks_[a].faces.size() < walks_[b].faces.size()) std::swap(a, b);
    Walk &to = walks_[a], &from = walks_[b];
    to.faces.insert(to.faces.end(), from.faces.begin(), from.faces.end());
    to.ahead.insert(to.ahead.end(), from.ahead.begin(), from.ahead.end());
    from.faces.clear();
    from.ahead.clear();
    from.into = a;
    --under_way_;
    return a;
  }

  const FaceGraph& graph_;
  EditLabels labels_;
  std::int32_t region_;
  std::vector<Walk> walks_;
  std::int32_t under_way_ = 0;
};

}  // namespace

std::vector<std::int32_t> cut_off(const FaceGraph& graph, EditLabels labels, std::span<const std::int32_t> starts) {
  ISIMP_ASSERT(
      std::all_of(starts.begin(), starts.end(),
                  [&](std::int32_t i) { return labels.get(i) >= 0 && labels.get(i) == labels.get(starts[0]); }),
      "walks begin in one region");
  Walks walks(graph, labels, labels.get(starts.front()));
  for (const std::int32_t face : starts) walks.start(face);
  walks.run();
  return walks.close();
}

}  // namespace isimp
