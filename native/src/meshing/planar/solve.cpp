#include "planar/solve.h"

#include <algorithm>

#include "planar/fit.h"

namespace isimp::meshing::planar {
namespace {

// tuned planar
constexpr int kPasses = 4;     ///< fits, all but the first without the corners that did not fit
constexpr int kReleases = 12;  ///< limit: rounds in which snapped planes are released
/// Share of a polygon's corners on too few planes, above which its plane is released. Source: own trials.
constexpr double kTooMany = 0.3;
constexpr Schedule kFirst{20, 1, 1e6}, kReleased{10, 1, 1e6}, kAgain{8, 10, 1e6};
constexpr int kAround = 4;  ///< rings around released planes that are solved again

/// Holds some planes where they are for as long as it lives.
class Pinned {
 public:
  template <class Function>
  Pinned(std::vector<Unit>& units, Function stays) : units_(units) {
    for (std::size_t u = 0; u < units.size(); ++u)
      if (!units[u].is_fixed() && stays(u)) pinned_.push_back(u);
    for (const std::size_t u : pinned_) units_[u].pinned = true;
  }
  ~Pinned() {
    for (const std::size_t u : pinned_) units_[u].pinned = false;
  }
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  std::vector<Unit>& units_;
  std::vector<std::size_t> pinned_;
};

/// Releases snapped planes that too many corners can't be on together with their other planes. Among the planes at such
/// a corner the one of the smallest unit is blamed.
/// \param kept  reset to true for all corners of released units
/// \return their units
std::vector<std::int32_t> release(std::vector<Unit>& units, const Around& around, Kept& kept) {
  std::vector<std::int32_t> misses(units.size(), 0);
  for (std::int32_t c = 0; c < around.corners(); ++c) {
    bool is_missed = false;
    std::int32_t least = kNone;
    for (const auto& [u, place] : around.of(c)) {
      const Unit& unit = units[u];
      is_missed = is_missed || (!kept[u][place] && unit.loop.size() > 3);
      if (!unit.held || !unit.scan.snapped) continue;
      if (least == kNone || unit.scan.area < units[least].scan.area) least = u;
    }
    if (is_missed && least != kNone) ++misses[least];
  }
  std::vector<std::int32_t> gone;
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (misses[u] <= kTooMany * static_cast<double>(units[u].loop.size())) continue;
    units[u].held = false;
    gone.push_back(static_cast<std::int32_t>(u));
    for (const std::int32_t c : units[u].loop)
      for (const auto& [other, place] : around.of(c)) kept[other][place] = 1;
  }
  return gone;
}

}  // namespace

void solve(std::vector<Unit>& units, const Around& around, Places& places, const Threads& threads, const Job& job) {
  Kept kept;
  for (const Unit& u : units) kept.emplace_back(u.loop.size(), 1);
  std::vector<Vec3> at;
  const auto fit_those = [&](const Schedule& schedule) {
    places.limit(units);  // planes may have been released
    fit(units, places, kept, schedule, job);
    kept = meet(units, around, places, threads, job, at);
  };
  fit_those(kFirst);
  for (int k = 0; k < kReleases; ++k) {
    const std::vector<std::int32_t> gone = release(units, around, kept);
    if (gone.empty()) break;
    const std::vector<bool> is_near = within_rings(units, around, gone, kAround);
    const Pinned far(units, [&](std::size_t u) { return !is_near[u]; });
    fit_those(kReleased);
  }
  for (int pass = 1; pass < kPasses; ++pass) {
    for (std::size_t u = 0; u < units.size(); ++u)
      units[u].missed = std::find(kept[u].begin(), kept[u].end(), 0) != kept[u].end();
    weigh_again(units);
    fit_those(kAgain);
  }
}

}  // namespace isimp::meshing::planar
