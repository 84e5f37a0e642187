#include "bound/dissolve.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

namespace isimp::detail {
namespace {

constexpr int kPasses = 6;                        // limit
constexpr std::size_t kDissolvePollMask = 0x7ff;  // work
constexpr std::size_t kProbes = 16;               // work: faces tested before a whole region is

/// The faces of each region, in rising order.
std::vector<std::vector<std::int32_t>> faces_of(const BoundedRegions& bounded) {
  std::vector<std::vector<std::int32_t>> faces(bounded.slab.size());
  const std::vector<std::int32_t>& label = bounded.regions.label;
  for (std::size_t i = 0; i < label.size(); ++i)
    if (label[i] != kNone) faces[label[i]].push_back(static_cast<std::int32_t>(i));
  return faces;
}

class Dissolving {
 public:
  Dissolving(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
             BoundedRegions& bounded)
      : graph_(surface.graph()),
        corners_(corners),
        need_(need),
        width_(width),
        regions_(bounded.regions),
        slab_(bounded.slab),
        faces_(faces_of(bounded)),
        component_(components_of_regions(surface, bounded)),
        left_(need.size(), 0),
        changed_(slab_.size(), 0),
        tried_(slab_.size(), -1) {
    for (std::size_t r = 0; r < slab_.size(); ++r) ++left_[component_of(static_cast<std::int32_t>(r))];
  }

  bool run(Job& job) {
    bool any = false;
    for (int pass = 0; pass < kPasses; ++pass) {
      bool gone = false;
      for (const std::int32_t r : smallest_first()) {
        job.poll();
        gone |= dissolve_one(r, false);
      }
      if (!gone) break;
      any = true;
    }
    return any;
  }

  void squeeze(Job& job) {
    std::vector<std::int32_t> order = smallest_first();
    order.resize(order.size() / 2);
    for (const std::int32_t r : order) {
      job.poll();
      dissolve_one(r, true);
    }
  }

  void renumber() {
    std::vector<std::int32_t> number(slab_.size(), kNone);
    std::int32_t count = 0;
    for (std::size_t r = 0; r < slab_.size(); ++r) {
      if (faces_[r].empty()) continue;
      number[r] = count;
      regions_.sum[count] = regions_.sum[r];
      slab_[count++] = slab_[r];
    }
    regions_.sum.resize(static_cast<std::size_t>(count));
    slab_.resize(static_cast<std::size_t>(count));
    for (std::int32_t& label : regions_.label)
      if (label != kNone) label = number[label];
  }

 private:
  struct Offer {
    double width;
    std::int32_t face, to;
    bool operator>(const Offer& o) const {
      return width != o.width ? width > o.width : face != o.face ? face > o.face : to > o.to;
    }
  };

  [[nodiscard]] std::vector<std::int32_t> smallest_first() const {
    std::vector<std::int32_t> order;
    for (std::int32_t r = 0; r < regions_.count(); ++r)
      if (!faces_[r].empty()) order.push_back(r);
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
      return std::pair(regions_.sum[a].weight, a) < std::pair(regions_.sum[b].weight, b);
    });
    return order;
  }

  [[nodiscard]] std::int32_t component_of(std::int32_t r) const { return component_.empty() ? 0 : component_[r]; }

  [[nodiscard]] std::vector<std::int32_t> regions_around(std::int32_t r) const {
    std::vector<std::int32_t> around;
    for (const std::int32_t f : faces_[r])
      for (const std::int32_t j : graph_.neighbours[f])
        if (const std::int32_t to = regions_.label[j]; to != r && to != kNone) around.push_back(to);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  /// Whether each face fits into some region around: else there is no need to try. A few faces first.
  [[nodiscard]] bool hopeful(std::int32_t r, std::span<const std::int32_t> around) const {
    const std::vector<std::int32_t>& faces = faces_[r];
    const auto fits = [&](std::int32_t f) {
      return std::any_of(around.begin(), around.end(),
                         [&](std::int32_t to) { return corners_.width_with(slab_[to], f) <= width_; });
    };
    for (std::size_t k = 0; k < kProbes; ++k)
      if (!fits(faces[k * faces.size() / kProbes])) return false;
    return std::all_of(faces.begin(), faces.end(), fits);
  }

  /// \param in_part  where not all of it can be removed, the rest may stay if it hangs together
  /// \return whether the region was removed
  bool dissolve_one(std::int32_t r, bool in_part) {
    if (left_[component_of(r)] <= need_[component_of(r)]) return false;
    const std::vector<std::int32_t> around = regions_around(r);
    // A vain attempt is not repeated until a region around has changed.
    std::int32_t latest = changed_[r];
    for (const std::int32_t to : around) latest = std::max(latest, changed_[to]);
    if (tried_[r] >= latest) return false;
    tried_[r] = clock_;
    if (!in_part && !hopeful(r, around)) return false;
    std::map<std::int32_t, Slab> before;
    const std::vector<std::int32_t> moved = give_away(r, before);
    const bool gone = moved.size() == faces_[r].size();
    if (!gone && !(in_part && hangs_together(r))) {
      for (const std::int32_t f : moved) regions_.label[f] = r;
      for (const auto& [to, slab] : before) slab_[to] = slab;
      return false;
    }
    if (!moved.empty()) changed_[r] = ++clock_;
    for (const std::int32_t f : moved) {
      const std::int32_t to = regions_.label[f];
      faces_[to].push_back(f);
      regions_.sum[to].add(graph_.faces[f]);
      regions_.sum[r].remove(graph_.faces[f]);
      changed_[to] = clock_;
    }
    std::erase_if(faces_[r], [&](std::int32_t f) { return regions_.label[f] != r; });
    if (gone) --left_[component_of(r)];
    return gone;
  }

  /// Moves faces to regions around as long as one fits there, the best first.
  /// \param before  slabs that grew by it
  std::vector<std::int32_t> give_away(std::int32_t r, std::map<std::int32_t, Slab>& before) {
    std::priority_queue<Offer, std::vector<Offer>, std::greater<>> queue;
    const auto offer = [&](std::int32_t face, std::int32_t to) {
      const double width = corners_.width_with(slab_[to], face);
      if (width <= width_) queue.push({width, face, to});
    };
    for (const std::int32_t f : faces_[r])
      for (const std::int32_t j : graph_.neighbours[f])
        if (const std::int32_t to = regions_.label[j]; to != r && to != kNone) offer(f, to);
    std::vector<std::int32_t> moved;
    while (!queue.empty() && moved.size() < faces_[r].size()) {
      const Offer next = queue.top();
      queue.pop();
      if (regions_.label[next.face] != r || corners_.width_with(slab_[next.to], next.face) > width_) continue;
      before.emplace(next.to, slab_[next.to]);
      corners_.add_to(slab_[next.to], next.face);
      regions_.label[next.face] = next.to;
      moved.push_back(next.face);
      for (const std::int32_t j : graph_.neighbours[next.face])
        if (regions_.label[j] == r) offer(j, next.to);
    }
    return moved;
  }

  /// Whether the faces that are still of a region are connected.
  bool hangs_together(std::int32_t r) {
    const auto first =
        std::find_if(faces_[r].begin(), faces_[r].end(), [&](std::int32_t f) { return regions_.label[f] == r; });
    std::vector<std::int32_t> met{*first};
    regions_.label[*first] = kNone;
    for (std::size_t k = 0; k < met.size(); ++k)
      for (const std::int32_t j : graph_.neighbours[met[k]])
        if (regions_.label[j] == r) {
          regions_.label[j] = kNone;
          met.push_back(j);
        }
    for (const std::int32_t f : met) regions_.label[f] = r;
    return met.size() ==
           static_cast<std::size_t>(std::count_if(faces_[r].begin(), faces_[r].end(),
                                                  [&](std::int32_t f) { return regions_.label[f] == r; }));
  }

  const FaceGraph& graph_;
  const Corners& corners_;
  std::span<const std::int32_t> need_;
  double width_;
  Regions& regions_;
  std::vector<Slab>& slab_;
  std::vector<std::vector<std::int32_t>> faces_;  // empty: the region was removed
  std::vector<std::int32_t> component_, left_;
  std::vector<std::int32_t> changed_, tried_;  // when a region last grew, and when it last stayed in vain
  std::int32_t clock_ = 0;
};

}  // namespace

Corners::Corners(const Surface& surface, Job& job)
    : graph_(surface.graph()), corner_(static_cast<std::size_t>(surface.face_count())) {
  const Mesh& mesh = surface.mesh();
  std::vector<std::int32_t> number(mesh.vertices().size(), kNone);
  vertex_.reserve(number.size());
  for (std::int32_t i = 0; i < graph_.size(); ++i) {
    if ((i & kDissolvePollMask) == 0) job.poll();
    const Triangle& t = mesh.triangles()[graph_.mesh_face[i]];
    for (int k = 0; k < 3; ++k) {
      std::int32_t& v = number[t[k]];
      if (v == kNone) {
        v = static_cast<std::int32_t>(vertex_.size());
        vertex_.push_back(mesh.vertices()[t[k]]);
      }
      corner_[i][k] = v;
    }
  }
}

std::vector<std::vector<std::int32_t>> Corners::points_of(const BoundedRegions& bounded, Job& job) const {
  std::vector<std::vector<std::int32_t>> points(bounded.slab.size());
  std::vector<std::int32_t> latest(vertex_.size(), kNone);  // the last region with each vertex
  for (std::size_t i = 0; i < corner_.size(); ++i) {
    if ((i & kDissolvePollMask) == 0) job.poll();
    const std::int32_t r = bounded.regions.label[i];
    if (r == kNone) continue;
    for (const std::int32_t v : corner_[i])
      if (std::exchange(latest[v], r) != r) points[r].push_back(v);
  }
  return points;
}

bool dissolve(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
              BoundedRegions& bounded, Job& job) {
  job.poll();
  Dissolving dissolving(surface, corners, need, width, bounded);
  const bool any = dissolving.run(job);
  if (any) dissolving.renumber();
  return any;
}

void squeeze(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
             BoundedRegions& bounded, Job& job) {
  job.poll();
  Dissolving dissolving(surface, corners, need, width, bounded);
  dissolving.squeeze(job);
  dissolving.renumber();
}

std::vector<std::int32_t> components_of_regions(const Surface& surface, const BoundedRegions& bounded) {
  std::vector<std::int32_t> component;
  if (surface.component_count() == 1) return component;
  component.resize(bounded.slab.size());
  for (std::int32_t i = 0; i < surface.graph().size(); ++i)
    if (const std::int32_t r = bounded.regions.label[i]; r != kNone)
      component[r] = surface.component()[surface.graph().mesh_face[i]];
  return component;
}

}  // namespace isimp::detail
