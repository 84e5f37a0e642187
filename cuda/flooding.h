#pragma once

#include <thrust/reduce.h>
#include <thrust/transform_scan.h>

#include <limits>

#include "device.h"

/// The kernels of queued flooding and of the repair, and the queue they share.
namespace isimp::parallel {

inline constexpr float kNoOffer = std::numeric_limits<float>::infinity();

struct Normal {
  float x, y, z;
};

/// What kernels see of a surface and its proxies.
struct View {
  const float* faces;              ///< (4 N)
  const std::int32_t* neighbours;  ///< (3 N)
  const Normal* normal;            ///< (R)
  const std::int32_t* seed;        ///< (R)
  std::int32_t* label;             ///< (N + 1), that of the sentinel is -1
  std::int32_t count;              ///< N

  /// Sums and products of floats, one rounding each: the same bits wherever it runs.
  ISIMP_KERNEL float error(std::int32_t face, std::int32_t region) const {
    const float* f = faces + 4 * static_cast<std::int64_t>(face);
    const Normal p = normal[region];
    const float x = f[0] - p.x, y = f[1] - p.y, z = f[2] - p.z;
    const float e = x * x + y * y + z * z;
    return e > 0x1p-24F ? e : 0x1p-24F;
  }
  ISIMP_KERNEL std::int32_t neighbour(std::int32_t face, int k) const {
    return neighbours[3 * static_cast<std::int64_t>(face) + k];
  }
  /// Of the regions next to a face the one with the least error, where that is below `least`; else `best` as it was.
  ISIMP_KERNEL void look_around(std::int32_t face, float& least, std::int32_t& best) const {
    const std::int32_t own = best;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t r = label[neighbour(face, k)];
      if (r < 0 || r == best) continue;
      const float e = error(face, r);
      if (e < least || (e == least && best != own && r < best)) {
        least = e;
        best = r;
      }
    }
  }
};

/// What each face of the queue shall be, from what all are now.
struct Choose {
  View view;
  const std::int32_t* queue;
  std::int32_t* chosen;

  ISIMP_KERNEL void operator()(std::int64_t q) const {
    const std::int32_t i = queue[q];
    std::int32_t best = view.label[i];
    if (best < 0 || view.seed[best] != i) {
      float least = best < 0 ? kNoOffer : view.error(i, best);
      view.look_around(i, least, best);
    }
    chosen[q] = best;
  }
};

/// The same where labels are final: a free face takes what is offered at no more than `level`, or waits.
struct ChooseOnce {
  View view;
  const std::int32_t* queue;
  std::int32_t* chosen;
  float level;

  ISIMP_KERNEL void operator()(std::int64_t q) const {
    std::int32_t best = view.label[queue[q]];
    if (best < 0) {
      float least = kNoOffer;
      view.look_around(queue[q], least, best);
      if (least > level) best = -1;
    }
    chosen[q] = best;
  }
};

/// The least error at which a face of the queue could get a region; infinity if it has one.
struct LeastOffer {
  View view;
  const std::int32_t* queue;

  ISIMP_KERNEL float operator()(std::int64_t q) const {
    float least = kNoOffer;
    std::int32_t best = view.label[queue[q]];
    if (best < 0) view.look_around(queue[q], least, best);
    return least;
  }
};

struct Less {
  ISIMP_KERNEL float operator()(float a, float b) const { return b < a ? b : a; }
};

/// Claims faces for the next queue: `mine` has a bit for each neighbour of a face that is now its to add, and kItself.
/// Who of several claims a face is left to chance, and does not change the set.
struct Claim {
  static constexpr std::int32_t kItself = 8;

  View view;
  std::int32_t* mark;  ///< (N) the step in which a face was claimed last
  std::int32_t step;

  ISIMP_KERNEL bool one(std::int32_t j) const { return shared(mark[j]).exchange(step, kRelaxed) != step; }
  ISIMP_KERNEL std::int32_t around(std::int32_t i) const {
    std::int32_t mine = 0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = view.neighbour(i, k);
      if (j != view.count && one(j)) mine |= 1 << k;
    }
    return mine;
  }
};

/// Gives the faces what was chosen; the neighbours of those that changed come next, and those still free wait on.
struct Apply {
  Claim claim;
  const std::int32_t* queue;
  const std::int32_t* chosen;
  std::int32_t* claims;

  ISIMP_KERNEL void operator()(std::int64_t q) const {
    const std::int32_t i = queue[q];
    claims[q] = 0;
    if (chosen[q] != claim.view.label[i]) {
      claim.view.label[i] = chosen[q];
      claims[q] = claim.around(i);
    } else if (chosen[q] < 0 && claim.one(i)) {
      claims[q] = Claim::kItself;
    }
  }
};

struct ClaimAroundSeeds {
  Claim claim;
  std::int32_t* claims;
  ISIMP_KERNEL void operator()(std::int64_t r) const { claims[r] = claim.around(claim.view.seed[r]); }
};

/// Free faces next to a region.
struct ClaimFree {
  Claim claim;
  std::int32_t* claims;
  ISIMP_KERNEL void operator()(std::int64_t i) const {
    const View& v = claim.view;
    const auto face = static_cast<std::int32_t>(i);
    bool joins = false;
    for (int k = 0; k < 3; ++k) joins |= v.label[v.neighbour(face, k)] >= 0;
    claims[i] = v.label[i] < 0 && joins && claim.one(face) ? Claim::kItself : 0;
  }
};

struct CountBits {
  ISIMP_KERNEL std::int32_t operator()(std::int32_t claims) const {
    return (claims & 1) + (claims >> 1 & 1) + (claims >> 2 & 1) + (claims >> 3 & 1);
  }
};

/// Writes the claimed faces where the exclusive scan of their number says.
template <class Faces>
struct Scatter {
  View view;
  Faces from;
  const std::int32_t* claims;
  const std::int32_t* offset;
  std::int32_t* next;

  ISIMP_KERNEL void operator()(std::int64_t q) const {
    std::int32_t at = offset[q];
    for (int k = 0; k < 3; ++k)
      if ((claims[q] >> k & 1) != 0) next[at++] = view.neighbour(from[q], k);
    if ((claims[q] & Claim::kItself) != 0) next[at] = from[q];
  }
};

/// The faces of a step, and how those of the next one are gathered: indicator, exclusive scan, scatter.
class Queue {
 public:
  explicit Queue(std::int32_t faces) : mark_(static_cast<std::size_t>(faces), 0) {}

  [[nodiscard]] std::int32_t size() const { return size_; }
  [[nodiscard]] const std::int32_t* faces() const { return raw(now_); }
  [[nodiscard]] std::int32_t* chosen() { return raw(chosen_); }

  void start_around_seeds(const View& view, std::int32_t seeds) {
    grow(claims_, seeds);
    for_all(0, seeds, ClaimAroundSeeds{next_claim(view), raw(claims_)});
    gather(view, seeds, view.seed);
  }
  void start_free(const View& view) {
    grow(claims_, view.count);
    for_all(0, view.count, ClaimFree{next_claim(view), raw(claims_)});
    gather(view, view.count, thrust::counting_iterator<std::int32_t>(0));
  }
  /// Applies what was chosen and makes the next queue.
  void advance(const View& view) {
    grow(claims_, size_);
    for_all(0, size_, Apply{next_claim(view), faces(), chosen(), raw(claims_)});
    gather(view, size_, faces());
  }

 private:
  static void grow(Array<std::int32_t>& array, std::int64_t size) {
    if (static_cast<std::int64_t>(array.size()) < size) array.resize(static_cast<std::size_t>(size + size / 4));
  }
  Claim next_claim(const View& view) { return {view, raw(mark_), ++step_}; }

  template <class Faces>
  void gather(const View& view, std::int64_t candidates, Faces from) {
    std::int32_t found = 0;
    if (candidates > 0) {
      grow(offset_, candidates);
      with_policy(candidates, [&](auto policy) {
        thrust::transform_exclusive_scan(policy, raw(claims_), raw(claims_) + candidates, raw(offset_), CountBits{}, 0,
                                         thrust::plus<std::int32_t>());
      });
      found = offset_[candidates - 1] + CountBits{}(claims_[candidates - 1]);
      grow(next_, found);
      grow(chosen_, found);
      for_all(0, candidates, Scatter<Faces>{view, from, raw(claims_), raw(offset_), raw(next_)});
    }
    now_.swap(next_);
    size_ = found;
  }

  Array<std::int32_t> now_, next_, chosen_, claims_, offset_, mark_;
  std::int32_t size_ = 0, step_ = 0;
};

}  // namespace isimp::parallel
