#pragma once

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>

#include <algorithm>
#include <limits>

#include "device.h"

/// The kernels of queued flooding and of the repair, and the queue they share.
namespace isimp::parallel::ISIMP_DEVICE {

inline constexpr float kNoOffer = std::numeric_limits<float>::infinity();

struct Normal {
  float x, y, z;
};

/// The view of a surface and its proxies for kernels.
struct View {
  const float* faces;              ///< (4 N)
  const std::int32_t* neighbours;  ///< (3 N)
  const Normal* normal;            ///< (R)
  const std::int32_t* seed;        ///< (R)
  std::int32_t* label;             ///< (N + 1), the sentinel has -1
  std::int32_t count;              ///< N

  /// Sums and products of floats, one rounding each: the same bits on all back ends.
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
  /// The region with the least error next to a face, if that is below `least`; else `best` does not change.
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

/// Chooses the next label of each face of the queue from the present labels of all.
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

/// As above where labels are final: a free face takes an offer of at most `level`, or waits.
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
/// Chance decides which of several faces claims a neighbour. Only faces are claimed to which the region is better than
/// their own. Their own region may or may not have changed in this very step; but it changes for the better only, so
/// that faces that are not claimed would not change, and faces that are claimed needlessly do not either.
struct Claim {
  static constexpr std::int32_t kItself = 8;

  View view;
  std::int32_t* mark;  ///< (N) the step in which a face was claimed last
  std::int32_t step;

  bool once;  ///< whether a face that has a region keeps it

  ISIMP_KERNEL bool one(std::int32_t j) const {
    const auto last = shared(mark[j]);
    return last.load(kRelaxed) != step && last.exchange(step, kRelaxed) != step;
  }
  ISIMP_KERNEL bool wants(std::int32_t j, std::int32_t region) const {
    const std::int32_t own = shared(view.label[j]).load(kRelaxed);
    return own < 0 || (!once && own != region && view.error(j, region) < view.error(j, own));
  }
  /// The neighbours of a face of that region.
  ISIMP_KERNEL std::int32_t around(std::int32_t i, std::int32_t region) const {
    std::int32_t mine = 0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = view.neighbour(i, k);
      if (j != view.count && wants(j, region) && one(j)) mine |= 1 << k;
    }
    return mine;
  }
};

/// Sets the chosen labels of the faces; the neighbours of changed faces come next, and free faces wait on.
struct Apply {
  Claim claim;
  const std::int32_t* queue;
  const std::int32_t* chosen;
  std::int32_t* claims;

  ISIMP_KERNEL void operator()(std::int64_t q) const {
    const std::int32_t i = queue[q];
    claims[q] = 0;
    if (chosen[q] != claim.view.label[i]) {
      shared(claim.view.label[i]).store(chosen[q], kRelaxed);
      claims[q] = claim.around(i, chosen[q]);
    } else if (chosen[q] < 0 && claim.one(i)) {
      claims[q] = Claim::kItself;
    }
  }
};

struct ClaimAroundSeeds {
  Claim claim;
  std::int32_t* claims;
  ISIMP_KERNEL void operator()(std::int64_t r) const {
    claims[r] = claim.around(claim.view.seed[r], static_cast<std::int32_t>(r));
  }
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

/// The number of faces that a candidate has claimed; none for the one after the last, so that a scan ends with the sum.
struct CountBits {
  const std::int32_t* claims;
  std::int64_t candidates;
  ISIMP_KERNEL std::int32_t operator()(std::int64_t q) const {
    const std::int32_t bits = q < candidates ? claims[q] : 0;
    return (bits & 1) + (bits >> 1 & 1) + (bits >> 2 & 1) + (bits >> 3 & 1);
  }
};

/// Writes the claimed faces at the places of the exclusive scan of their number.
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

/// The faces of a step, and the gathering of the faces of the next one: indicator, exclusive scan, scatter.
class Queue {
 public:
  Queue(Memory& memory, std::int32_t faces)
      : memory_(memory),
        now_(memory),
        next_(memory),
        chosen_(memory),
        claims_(memory),
        offset_(memory),
        mark_(memory, static_cast<std::size_t>(faces)) {
    set_all(mark_, 0);
  }

  [[nodiscard]] std::int32_t size() const { return size_; }
  [[nodiscard]] const std::int32_t* faces() const { return now_.data(); }
  [[nodiscard]] std::int32_t* chosen() { return chosen_.data(); }

  void start_around_seeds(const View& view, std::int32_t seeds) {
    once_ = false;
    grow(claims_, seeds);
    for_all(0, seeds, ClaimAroundSeeds{next_claim(view), claims_.data()});
    gather(view, seeds, view.seed);
  }
  /// For faces that have no region yet; the others keep theirs.
  void start_free(const View& view) {
    once_ = true;
    grow(claims_, view.count);
    for_all(0, view.count, ClaimFree{next_claim(view), claims_.data()});
    gather(view, view.count, thrust::counting_iterator<std::int32_t>(0));
  }
  /// Applies the chosen labels and makes the next queue.
  void advance(const View& view) {
    grow(claims_, size_);
    for_all(0, size_, Apply{next_claim(view), faces(), chosen(), claims_.data()});
    gather(view, size_, faces());
  }

 private:
  /// Makes room for a queue, which never has a face twice; the old content is lost.
  void grow(Array<std::int32_t>& array, std::int64_t size) {
    const auto most = static_cast<std::int64_t>(mark_.size()) + 1;
    if (static_cast<std::int64_t>(array.size()) < size)
      array.resize(static_cast<std::size_t>(std::max(size, std::min(2 * size, most))));
  }
  Claim next_claim(const View& view) { return {view, mark_.data(), ++step_, once_}; }

  template <class Faces>
  void gather(const View& view, std::int64_t candidates, Faces from) {
    std::int32_t found = 0;
    if (candidates > 0) {
      grow(offset_, candidates + 1);
      const auto bits = thrust::make_transform_iterator(thrust::counting_iterator<std::int64_t>(0),
                                                        CountBits{claims_.data(), candidates});
      scan_all(memory_, bits, candidates + 1, offset_.data());
      device_copy(&found, offset_.data() + candidates, sizeof found);
      grow(next_, found);
      grow(chosen_, found);
      for_all(0, candidates, Scatter<Faces>{view, from, claims_.data(), offset_.data(), next_.data()});
    }
    now_.swap(next_);
    size_ = found;
  }

  Memory& memory_;
  Array<std::int32_t> now_, next_, chosen_, claims_, offset_, mark_;
  std::int32_t size_ = 0, step_ = 0;
  bool once_ = false;
};

}  // namespace isimp::parallel::ISIMP_DEVICE
