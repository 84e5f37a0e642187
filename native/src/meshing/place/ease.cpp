#include "place/ease.h"

#include <algorithm>
#include <utility>

#include "complex/transaction.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr int kRounds = 20;
constexpr std::int32_t kShare = 6;

class Easing {
 public:
  Easing(State& state, Findings& findings, const Scope& scope, Job& job)
      : s_(state), findings_(findings), scope_(scope), job_(job), faulty_(findings.faulty()), transaction_(state) {}

  /// \param share  one in `share` corners is dropped; turns 0 to share - 1 cover all
  void run(std::int32_t share, std::int32_t turn) {
    if (drop_bends(share, turn)) settle();
    transaction_.commit();
  }

  /// Drops and adds corners.
  void turn(std::span<const std::int32_t> vertices) {
    bool any = false;
    for (const std::int32_t v : vertices) {
      if (!s_.complex.is_corner(v)) {
        s_.add_corner(v);
        any = true;
      } else {
        any = s_.drop_corner(v) || any;
      }
    }
    if (any) settle();
    transaction_.commit();
  }

 private:
  /// Updates the polygons, and restores the corners of pieces that have become faulty.
  void settle() {
    findings_.judge(s_.update_in_place({}));
    for (int round = 0; round < kRounds; ++round) {
      job_.poll();
      std::vector<std::int32_t> pieces = near_faults();
      if (pieces.empty()) return;
      for (const std::int32_t l : pieces) transaction_.restore_corners(l);
      findings_.judge(s_.update_in_place(std::move(pieces)));
    }
  }

  /// \return whether there is any that could be dropped
  bool drop_bends(std::int32_t share, std::int32_t turn) {
    std::vector<std::int32_t> bent(s_.complex.bent().begin(), s_.complex.bent().end());
    sort_unique(bent);
    bool any = false;
    for (const std::int32_t v : bent) {
      if (v % share != turn || !s_.complex.is_corner(v)) continue;
      bool spared = false, asked = false;
      for_each_leaving(s_.mesh, v, [&](std::int32_t h) {
        spared = spared || faulty_[s_.labels.label[h / 3]];
        asked = asked || scope_.has(s_.labels.label[h / 3]);
      });
      any = (asked && !spared && s_.drop_corner(v)) || any;
    }
    return any;
  }

  /// Newly faulty pieces, plus one more ring of neighbours for each repeated failure.
  std::vector<std::int32_t> near_faults() {
    const std::vector<bool> now = findings_.faulty();
    std::vector<std::int32_t> near;
    rings_.resize(now.size(), 0);
    for (std::size_t l = 0; l < now.size(); ++l) {
      if (!now[l] || faulty_[l]) continue;
      std::vector<std::int32_t> zone{static_cast<std::int32_t>(l)};
      for (int ring = rings_[l]++; ring > 0; --ring) s_.add_neighbours(zone);
      near.insert(near.end(), zone.begin(), zone.end());
    }
    sort_unique(near);
    return near;
  }

  State& s_;
  Findings& findings_;
  const Scope& scope_;
  Job& job_;
  const std::vector<bool> faulty_;  // by piece, before
  Transaction transaction_;
  std::vector<int> rings_;  // by piece: how often it was found to be faulty
};

}  // namespace

void ease(State& state, Findings& findings, const Scope& scope, Job& job) {
  Easing(state, findings, scope, job).run(1, 0);
  // Corners that were restored because of faults of their neighbours are dropped again, a share at a time.
  for (std::int32_t turn = 0; turn < kShare; ++turn) Easing(state, findings, scope, job).run(kShare, turn);
}

void turn_corners(State& state, Findings& findings, std::span<const std::int32_t> vertices, Job& job) {
  Easing(state, findings, Scope(), job).turn(vertices);
}

}  // namespace isimp::meshing
