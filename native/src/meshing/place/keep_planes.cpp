#include "place/keep_planes.h"

#include <algorithm>
#include <map>
#include <span>

#include "isimp/core/sorted.h"
#include "judge/trials.h"

namespace isimp::meshing {
namespace {

// tuned regular
constexpr int kKeepPasses = 2;  ///< a plane may be met only after its neighbours have moved

class Keeper {
 public:
  Keeper(State& state, Defects& defects, Job& job)
      : s_(state), defects_(defects), job_(job), planes_(state.planes), charts_(state.regions) {
    for (std::int32_t l = 0; l < s_.labels.chart_count(); ++l)
      if (s_.labels.charts[l].face != kNone && is_asked(s_.labels.charts[l].region))
        charts_[s_.labels.charts[l].region].push_back(l);
  }

  std::vector<std::int32_t> run() {
    std::vector<std::int32_t> left = by_area();
    keep_parts(left);
    for (int pass = 0; pass < kKeepPasses && !left.empty(); ++pass)
      std::erase_if(left, [&](std::int32_t r) {
        job_.poll();
        return keeps({&r, 1}, true) || keeps({&r, 1}, false);
      });
    defects_.renew_hits();
    std::sort(left.begin(), left.end());
    return left;
  }

 private:
  [[nodiscard]] bool is_asked(std::int32_t r) const {
    return s_.partition.is_snapped(r) && (!s_.options.planar || s_.partition.region_held[r] == kPlaneRound);
  }

  /// The regions with snapped planes, the largest first.
  [[nodiscard]] std::vector<std::int32_t> by_area() const {
    std::vector<double> area(charts_.size(), 0);
    std::vector<std::int32_t> regions;
    for (std::int32_t r = 0; r < s_.regions; ++r) {
      for (const std::int32_t l : charts_[r]) area[r] += s_.planes[l].area;
      if (!charts_[r].empty()) regions.push_back(r);
    }
    std::stable_sort(regions.begin(), regions.end(), [&](auto a, auto b) { return area[a] > area[b]; });
    return regions;
  }

  /// Tries all cells of a round part together, since their planes meet by symmetry, and removes the kept ones.
  void keep_parts(std::vector<std::int32_t>& left) {
    std::map<std::int32_t, std::vector<std::int32_t>> parts;
    for (const std::int32_t r : left)
      if (s_.partition.region_held[r] == kPlaneRound) parts[s_.partition.region_cell[r].proxy].push_back(r);
    std::vector<std::int32_t> kept;
    for (const auto& [part, cells] : parts) {
      job_.poll();
      bool is_kept = cells.size() > 1;
      for (int pass = 0; pass < kKeepPasses && is_kept; ++pass) is_kept = keeps(cells, true);
      if (is_kept) kept.insert(kept.end(), cells.begin(), cells.end());
    }
    sort_unique(kept);
    std::erase_if(left, [&](std::int32_t r) { return std::binary_search(kept.begin(), kept.end(), r); });
  }

  [[nodiscard]] bool is_held_at(std::int32_t c) const {
    const auto around = s_.polygons.at(c);
    return std::any_of(around.begin(), around.end(),
                       [&](std::int32_t q) { return planes_[s_.polygons.chart(q)].held; });
  }

  /// Tries to move the corners of regions onto their planes and the planes that are kept already.
  /// \param with_neighbours  whether the neighbours' corners at kept planes move too
  bool keeps(std::span<const std::int32_t> regions, bool with_neighbours) {
    std::vector<std::int32_t> charts;
    for (const std::int32_t r : regions)
      for (const std::int32_t l : charts_[r]) {
        hold(planes_[l], s_.partition, r, s_.mesh.origin());
        charts.push_back(l);
      }
    std::vector<std::int32_t> near = charts;
    if (with_neighbours) s_.add_neighbours(near);
    std::vector<std::int32_t> moving = s_.polygons.corners_of(near);
    std::erase_if(moving, [&](std::int32_t c) { return !is_held_at(c); });
    const auto move = [&] {
      s_.move_onto(planes_, moving);
      return true;
    };
    const bool is_kept = attempt(s_, defects_, s_.polygons.charts_at(moving), kNone, move, Places::moved);
    for (const std::int32_t l : charts)
      if (!is_kept) planes_[l] = s_.planes[l];
    return is_kept;
  }

  State& s_;
  Defects& defects_;
  Job& job_;
  std::vector<Plane> planes_;                      // by chart: the snapped plane if it is kept, else that of the state
  std::vector<std::vector<std::int32_t>> charts_;  // by region: its charts, if its plane is snapped
};

}  // namespace

std::vector<std::int32_t> keep_to_planes(State& state, Defects& defects, Job& job) {
  return Keeper(state, defects, job).run();
}

}  // namespace isimp::meshing
