#include "find/face_labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "fit/numbers.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr int kSweeps = 12;            ///< moves of the faces at borders
constexpr int kFilters = 3;            ///< averages of the normals
constexpr double kAlikeNormals = 0.6;  ///< cosine: neighbours further apart are not averaged
constexpr double kNoSurface = 1.2;     ///< cost of a face on none
constexpr double kVote = 0.25;         ///< reduction of the cost by each neighbour of the same label
constexpr double kFitsAtAll = 4;       ///< misfit of a part on no surface that joins one

/// Normals of faces after kFilters averages with neighbours. Only requested ones are computed, since labels
/// change at borders alone.
class FilteredNormals {
 public:
  explicit FilteredNormals(const Faces& faces)
      : f_(faces), sum_(static_cast<std::size_t>(kFilters) * faces.size()), known_(sum_.size() / kFilters, 0) {}

  [[nodiscard]] Vec3 at(std::int32_t i) { return sum(kFilters, i).normalized(); }

 private:
  /// The sum of normals after a number of averages.
  Vec3 sum(int averages, std::int32_t i) {
    if (averages == 0) return std::max(f_.area(i), 1e-30) * f_.normal(i);
    Vec3& now = sum_[static_cast<std::size_t>(kFilters) * i + averages - 1];
    if (known_[i] >= averages) return now;
    const Vec3 mine = sum(averages - 1, i);
    now = mine;
    for (const std::int32_t j : f_.graph().neighbours[i]) {
      if (j == f_.size()) continue;
      const Vec3 other = sum(averages - 1, j);
      const double dot = mine.dot(other);
      if (dot > 0 && dot * dot > kAlikeNormals * kAlikeNormals * mine.squaredNorm() * other.squaredNorm()) now += other;
    }
    known_[i] = static_cast<std::uint8_t>(averages);
    return now;
  }

  const Faces& f_;
  std::vector<Vec3> sum_;  // by face, its sums after one average and more
  std::vector<std::uint8_t> known_;
};

std::vector<Locator> locators(const std::vector<Found>& found) {
  std::vector<Locator> all;
  all.reserve(found.size());
  for (const Found& f : found) all.emplace_back(f.surface);
  return all;
}

class Borders {
 public:
  Borders(const Faces& faces, const Points& points, const std::vector<Found>& found, const Nearness& near)
      : f_(faces), graph_(faces.graph()), p_(points), on_(locators(found)), near_(near), normal_(faces) {
    const Some own = owners(points, found);
    label_.resize(static_cast<std::size_t>(faces.size()));
    for (std::int32_t i = 0; i < faces.size(); ++i)
      label_[i] = points.of_face[i] == kNone ? kNone : own[points.of_face[i]];
  }

  Some run(Job& job) {
    Some active;
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (is_open(i) && at_border(i)) active.push_back(i);
    for (int sweep = 0; sweep < kSweeps && !active.empty(); ++sweep) {
      job.poll();
      active = moved(active);
    }
    for (int k = 0; k < 3; ++k)
      if (!give_rest_away(job)) break;
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (!is_open(i)) label_[i] = kNone;
    return std::move(label_);
  }

 private:
  [[nodiscard]] bool is_open(std::int32_t i) const { return p_.of_face[i] != kNone; }
  [[nodiscard]] bool at_border(std::int32_t i) const {
    return std::any_of(graph_.neighbours[i].begin(), graph_.neighbours[i].end(),
                       [&](std::int32_t j) { return j != graph_.size() && label_[j] != label_[i]; });
  }
  [[nodiscard]] bool is_smooth(std::int32_t i, std::int32_t j) const {
    if (!is_open(i) || !is_open(j)) return false;
    return p_.normal[p_.of_face[i]].dot(p_.normal[p_.of_face[j]]) > kCrease;
  }

  [[nodiscard]] double cost(std::int32_t i, std::int32_t label) {
    if (label == kNone) return kNoSurface;
    const Residual r = on_[label].residual(f_.centre(i));
    const double d = r.distance / near_.distance;
    return 0.5 * d * d + (1 - r.normal.dot(normal_.at(i))) / (1 - std::cos(near_.turn));
  }

  /// Sets the label of each of some faces to the cheapest label among its own and its neighbours' ones.
  /// \return the faces that changed or have a changed neighbour, and are at a border
  Some moved(const Some& active) {
    std::vector<bool> next(static_cast<std::size_t>(f_.size()), false);
    for (const std::int32_t i : active) {
      std::array<std::int32_t, 4> labels{label_[i], label_[i], label_[i], label_[i]};
      std::array<int, 4> votes{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t j = graph_.neighbours[i][k];
        if (j != graph_.size() && is_smooth(i, j)) labels[k + 1] = label_[j];
      }
      for (const std::int32_t j : graph_.neighbours[i])
        for (std::size_t k = 0; k < 4; ++k) votes[k] += j != graph_.size() && label_[j] == labels[k];
      std::int32_t best = label_[i];
      double least = cost(i, best) - kVote * votes[0];
      for (std::size_t k = 1; k < 4; ++k) {
        if (labels[k] == best) continue;
        const double c = cost(i, labels[k]) - kVote * votes[k];
        if (c >= least) continue;
        least = c;
        best = labels[k];
      }
      if (best == label_[i]) continue;
      label_[i] = best;
      next[i] = true;
      for (const std::int32_t j : graph_.neighbours[i])
        if (j != graph_.size() && is_open(j)) next[j] = true;
    }
    Some faces;
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (next[i] && at_border(i)) faces.push_back(i);
    return faces;
  }

  /// Adds parts without a surface to the neighbour that fits them.
  bool give_rest_away(Job& job) {
    const LabelParts parts = parts_of_labels(f_, label_, job);
    std::vector<Some> members(parts.label.size());
    std::map<std::pair<std::int32_t, std::int32_t>, int> beside;
    for (std::int32_t i = 0; i < f_.size(); ++i) {
      if (!is_open(i) || label_[i] != kNone) continue;
      members[parts.part[i]].push_back(i);
      for (const std::int32_t j : graph_.neighbours[i])
        if (j != graph_.size() && label_[j] != kNone) ++beside[{parts.part[i], label_[j]}];
    }
    std::map<std::int32_t, std::pair<double, std::int32_t>> best;
    for (const auto& [pair, edges] : beside) {
      const auto& [part, label] = pair;
      const double misfit = misfit_of(members[part], label);
      if (misfit >= kFitsAtAll) continue;
      const double cost = misfit - 0.01 * edges;
      const auto [at, is_new] = best.try_emplace(part, cost, label);
      if (!is_new && cost < at->second.first) at->second = {cost, label};
    }
    for (const auto& [part, to] : best)
      for (const std::int32_t i : members[part]) label_[i] = to.second;
    return !best.empty();
  }

  [[nodiscard]] double misfit_of(const Some& members, std::int32_t label) {
    double square = 0, turn = 0, area = 0;
    for (std::size_t k = 0; k < members.size(); k += 1 + members.size() / kMostSamples) {
      const std::int32_t i = members[k];
      const Residual r = on_[label].residual(f_.centre(i));
      square += f_.area(i) * r.distance * r.distance;
      turn += f_.area(i) * (1 - r.normal.dot(normal_.at(i)));
      area += f_.area(i);
    }
    area = std::max(area, kTiny);
    return std::sqrt(square / area) / near_.distance + turn / area / (1 - std::cos(2 * near_.turn));
  }

  const Faces& f_;
  const FaceGraph& graph_;
  const Points& p_;
  std::vector<Locator> on_;  // by surface
  const Nearness& near_;
  FilteredNormals normal_;
  Some label_;
};

}  // namespace

LabelParts parts_of_labels(const Faces& faces, const Some& labels, Job& job) {
  const FaceGraph& graph = faces.graph();
  LabelParts parts;
  parts.part.assign(labels.size(), kNone);
  Some stack;
  for (std::int32_t f = 0; f < faces.size(); ++f) {
    if ((f & 0xffff) == 0) job.poll();
    if (parts.part[f] != kNone) continue;
    const auto number = static_cast<std::int32_t>(parts.label.size());
    parts.label.push_back(labels[f]);
    double& area = parts.area.emplace_back(0.0);
    parts.part[f] = number;
    stack.push_back(f);
    while (!stack.empty()) {
      const std::int32_t i = stack.back();
      stack.pop_back();
      area += faces.area(i);
      for (const std::int32_t j : graph.neighbours[i]) {
        if (j == graph.size() || parts.part[j] != kNone || labels[j] != labels[i]) continue;
        parts.part[j] = number;
        stack.push_back(j);
      }
    }
  }
  return parts;
}

void absorb_fragments(const Faces& faces, Some& labels, const std::function<double(std::int32_t)>& small,
                      const Misfit& misfit, const std::function<bool(std::int32_t)>& takes, Job& job) {
  const FaceGraph& graph = faces.graph();
  for (int round = 0; round < 4; ++round) {
    const LabelParts parts = parts_of_labels(faces, labels, job);
    std::map<std::int32_t, double> largest;
    for (std::size_t k = 0; k < parts.label.size(); ++k) {
      double& most = largest[parts.label[k]];
      most = std::max(most, parts.area[k]);
    }
    std::vector<bool> is_bad(parts.label.size(), false);
    for (std::size_t k = 0; k < is_bad.size(); ++k) {
      const double least = small(parts.label[k]);
      is_bad[k] =
          parts.area[k] < kSpeck * least || (parts.area[k] < 0.999 * largest[parts.label[k]] && parts.area[k] < least);
    }
    std::map<std::pair<std::int32_t, std::int32_t>, int> beside;
    for (std::int32_t i = 0; i < faces.size(); ++i) {
      if (!is_bad[parts.part[i]]) continue;
      for (const std::int32_t j : graph.neighbours[i])
        if (j != graph.size() && parts.part[j] != parts.part[i] && !is_bad[parts.part[j]] && takes(labels[j]))
          ++beside[{parts.part[i], labels[j]}];
    }
    std::map<std::int32_t, std::map<std::int32_t, double>> worth;  // by part and label of a neighbour
    for (const auto& [pair, edges] : beside) worth[pair.first][pair.second] = edges;
    if (misfit != nullptr) {
      std::map<std::int32_t, std::map<std::int32_t, double>> sum;
      for (std::int32_t i = 0; i < faces.size(); ++i) {
        if (!is_bad[parts.part[i]]) continue;
        if (const auto at = worth.find(parts.part[i]); at != worth.end())
          for (const auto& [label, edges] : at->second) sum[parts.part[i]][label] -= misfit(i, label);
      }
      worth.swap(sum);
    }
    std::map<std::int32_t, std::int32_t> to;
    for (const auto& [part, by_label] : worth)
      to[part] = std::max_element(by_label.begin(), by_label.end(), [](const auto& a, const auto& b) {
                   return a.second < b.second;
                 })->first;
    if (to.empty()) return;
    for (std::int32_t i = 0; i < faces.size(); ++i) {
      if (!is_bad[parts.part[i]]) continue;
      if (const auto at = to.find(parts.part[i]); at != to.end()) labels[i] = at->second;
    }
  }
}

Some face_labels(const Faces& faces, const Points& points, const std::vector<Found>& found, const Nearness& near,
                 Job& job) {
  return Borders(faces, points, found, near).run(job);
}

}  // namespace isimp::curved
