#include <array>
#include <bit>
#include <cmath>

#include "soup.h"

namespace isimp::detail {
namespace {

/// Finds points that lie within a distance of each other, by a hash of the cells of a grid of that width.
class Places {
 public:
  Places(const std::vector<Vec3>& points, std::size_t expected, double tolerance)
      : points_(points), tolerance_(tolerance), heads_(std::bit_ceil(2 * expected + 1), kNone) {}

  /// The nearest point kept so far within the tolerance, the earliest of equals; else kNone, and `v` is kept.
  std::int32_t find_or_keep(std::int32_t v) {
    const Vec3 home = cell(points_[v]);
    std::int32_t best = kNone;
    double best_distance = tolerance_;
    const int reach = tolerance_ > 0 ? 1 : 0;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        for (int k = -reach; k <= reach; ++k)
          for (std::int32_t e = heads_[slot(home + Vec3(i, j, k))]; e != kNone; e = next_[e]) {
            const std::int32_t other = kept_[e];
            const double distance = (points_[other] - points_[v]).norm();
            if (distance < best_distance || (distance == best_distance && (best == kNone || other < best))) {
              best = other;
              best_distance = distance;
            }
          }
    if (best == kNone) {
      std::int32_t& head = heads_[slot(home)];
      next_.push_back(head);
      head = static_cast<std::int32_t>(kept_.size());
      kept_.push_back(v);
    }
    return best;
  }

 private:
  [[nodiscard]] Vec3 cell(const Vec3& p) const {
    if (tolerance_ == 0) return p;
    return {std::floor(p.x() / tolerance_), std::floor(p.y() / tolerance_), std::floor(p.z() / tolerance_)};
  }
  [[nodiscard]] std::size_t slot(const Vec3& cell) const {
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(cell[k] + 0.0)) * 0x9e3779b97f4a7c15ULL;  // + 0.0 makes -0 into 0
      hash ^= hash >> 32;
    }
    return hash & (heads_.size() - 1);
  }

  const std::vector<Vec3>& points_;
  double tolerance_;
  std::vector<std::int32_t> heads_, next_, kept_;
};

}  // namespace

bool weld_borders(Soup& soup, const EdgeGroups& edges, double tolerance, Job& job) {
  std::vector<char> on_border(soup.vertices.size(), 0);
  edges.for_each(job, [&](const EdgeGroup& edge) {
    if (edge.size() == 1) on_border[soup.from(edge[0])] = on_border[soup.to(edge[0])] = 1;
  });
  std::vector<std::int32_t> border;
  for (std::size_t v = 0; v < on_border.size(); ++v)
    if (on_border[v]) border.push_back(static_cast<std::int32_t>(v));

  Places places(soup.vertices, border.size(), tolerance);
  std::vector<std::int32_t> stands_for;  // (V) filled once the first pair is found
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (i % kPollEvery == 0) job.poll();
    const std::int32_t v = border[i], other = places.find_or_keep(v);
    if (other == kNone) continue;
    if (stands_for.empty()) {
      stands_for.resize(soup.vertices.size());
      for (std::size_t u = 0; u < stands_for.size(); ++u) stands_for[u] = static_cast<std::int32_t>(u);
    }
    stands_for[v] = other;
  }
  if (stands_for.empty()) return false;

  soup.welded = soup.named;
  std::vector<char> collapsed(soup.named.size(), 0);
  bool any_collapsed = false;
  for (std::size_t f = 0; f < soup.welded.size(); ++f) {
    Triangle& t = soup.welded[f];
    for (std::int32_t& v : t) v = stands_for[v];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) continue;
    collapsed[f] = 1;
    any_collapsed = true;
    soup.count_face(Mend::repeated_index_faces, static_cast<std::int32_t>(f));
  }
  if (any_collapsed) soup.drop(collapsed);
  return true;
}

}  // namespace isimp::detail
