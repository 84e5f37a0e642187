#pragma once

#include <cstdint>
#include <limits>

#include "device.h"
#include "isimp/core/job.h"

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
  /// The region with the least error next to a face, if that is below `least`; else `best` does not change. All numbers
  /// are read before the first comparison, since a device can wait for all at once.
  ISIMP_KERNEL void look_around(std::int32_t face, float& least, std::int32_t& best) const {
    const std::int32_t own = best;
    std::int32_t region[3];
    float offer[3];
    for (int k = 0; k < 3; ++k) region[k] = label[neighbour(face, k)];
    for (int k = 0; k < 3; ++k) offer[k] = error(face, region[k] < 0 ? 0 : region[k]);
    for (int k = 0; k < 3; ++k) {
      if (region[k] < 0 || region[k] == best) continue;
      if (offer[k] < least || (offer[k] == least && best != own && region[k] < best)) {
        least = offer[k];
        best = region[k];
      }
    }
  }
};

/// The numbers of a flooding on the device.
struct Progress {
  /// Faces of the queue of step s, at s % 3. A step uses its own, counts the next and clears the one after, so that no
  /// number is written that a thread may still read.
  std::int32_t size[3];
  std::int32_t steps;  ///< made by the last call of repeat
};

template <class Flood>
struct Applied;

/// The data and the two parts of a step of flooding. The first part chooses a label for each face of the queue from the
/// present labels of all faces. The second part applies the chosen labels and queues neighbours of changed faces for the
/// next step. The order of a queue is random and does not affect a label.
///
/// A neighbour is queued only if the region is better than its own. Its own region may or may not have changed in this
/// very step; but it changes for the better only, so that faces that are not queued would not change, and faces that are
/// queued needlessly do not either.
/// \tparam kOnce  labels are final, and a free face takes an offer of at most the level
template <bool kOnce>
struct Flood {
  View view;
  std::int32_t* even;    ///< (N) the queues of steps with even numbers
  std::int32_t* odd;     ///< (N)
  std::int32_t* chosen;  ///< (N) by place in the queue
  std::int32_t* mark;    ///< (N) the last step for which a face was queued
  Progress* progress;
  float level;  ///< of an error; infinity where labels are not final

  /// The source of the queue of a step.
  [[nodiscard]] ISIMP_KERNEL Applied<Flood> applied(std::int32_t step) const { return {*this, step}; }
  [[nodiscard]] ISIMP_KERNEL std::int32_t size(std::int32_t step) const { return progress->size[step % 3]; }

  /// \param q  place in the queue
  ISIMP_KERNEL void choose(std::int64_t q, std::int32_t step) const {
    const std::int32_t i = queue(step)[q];
    std::int32_t best = view.label[i];
    if (best < 0 || (!kOnce && view.seed[best] != i)) {
      float least = best < 0 ? kNoOffer : view.error(i, best);
      view.look_around(i, least, best);
      if (kOnce && least > level) best = -1;
    }
    chosen[q] = best;
    if (q == 0) progress->size[(step + 2) % 3] = 0;
  }
  /// \return what `add` is to queue next
  ISIMP_KERNEL std::int32_t apply(std::int64_t q, std::int32_t step) const {
    const std::int32_t i = queue(step)[q], best = chosen[q];
    if (best == view.label[i]) return 0;
    shared(view.label[i]).store(best, kRelaxed);
    return wanting(i, best, step + 1);
  }

  /// The neighbours of a face that want its region and are not queued yet for a step: a bit each.
  ISIMP_KERNEL std::int32_t wanting(std::int32_t i, std::int32_t region, std::int32_t next) const {
    std::int32_t own[3], last[3], bits = 0;
    for (int k = 0; k < 3; ++k) own[k] = shared(view.label[view.neighbour(i, k)]).load(kRelaxed);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = view.neighbour(i, k) == view.count ? i : view.neighbour(i, k);
      last[k] = shared(mark[j]).load(kRelaxed);
      const bool better = !kOnce && view.error(j, region) < view.error(j, own[k] < 0 ? 0 : own[k]);
      if (view.neighbour(i, k) != view.count && (own[k] < 0 || (better && own[k] != region))) bits |= 1 << k;
    }
    for (int k = 0; k < 3; ++k)
      if ((bits >> k & 1) != 0 &&
          (last[k] == next || shared(mark[view.neighbour(i, k)]).exchange(next, kRelaxed) == next))
        bits -= 1 << k;
    return bits;
  }
  /// Adds faces to the queue of a step, from a place in it on.
  /// \param bits  kItself, or a bit for each neighbour
  ISIMP_KERNEL void add(std::int32_t i, std::int32_t bits, std::int32_t next, std::int32_t at) const {
    std::int32_t* const to = queue(next);
    if (bits == kItself) to[at] = i;
    for (int k = 0; k < 3; ++k)
      if ((bits >> k & 1) != 0) to[at++] = view.neighbour(i, k);
  }
  [[nodiscard]] ISIMP_KERNEL static std::int32_t number(std::int32_t bits) {
    return bits == kItself ? 1 : (bits & 1) + (bits >> 1 & 1) + (bits >> 2 & 1);
  }
  [[nodiscard]] ISIMP_KERNEL std::int32_t* queue(std::int32_t step) const { return step % 2 == 0 ? even : odd; }

  static constexpr std::int32_t kItself = 8;
};

/// Sources of a queue: for each i a face, and what Flood::add is to queue of it.

/// The queue of the step before.
template <class Flood>
struct Applied {
  Flood flood;
  std::int32_t step;
  [[nodiscard]] ISIMP_KERNEL std::int32_t face(std::int64_t q) const { return flood.queue(step - 1)[q]; }
  ISIMP_KERNEL std::int32_t bits(std::int64_t q) const { return flood.apply(q, step - 1); }
};

/// The seeds.
struct AroundSeeds {
  Flood<false> flood;
  std::int32_t step;
  [[nodiscard]] ISIMP_KERNEL std::int32_t face(std::int64_t r) const { return flood.view.seed[r]; }
  ISIMP_KERNEL std::int32_t bits(std::int64_t r) const {
    return flood.wanting(face(r), static_cast<std::int32_t>(r), step);
  }
};

/// The free faces next to a region, among all faces.
struct FreeFaces {
  Flood<true> flood;
  std::int32_t step;
  [[nodiscard]] ISIMP_KERNEL std::int32_t face(std::int64_t i) const { return static_cast<std::int32_t>(i); }
  ISIMP_KERNEL std::int32_t bits(std::int64_t i) const {
    const View& v = flood.view;
    bool joins = false;
    for (int k = 0; k < 3; ++k) joins |= v.label[v.neighbour(face(i), k)] >= 0;
    return v.label[i] < 0 && joins ? Flood<true>::kItself : 0;
  }
};

/// The least error at which a face could get a region; infinity if it has one or is next to none.
struct LeastOffer {
  View view;
  ISIMP_KERNEL float operator()(std::int64_t i) const {
    float least = kNoOffer;
    std::int32_t best = view.label[i];
    if (best < 0) view.look_around(static_cast<std::int32_t>(i), least, best);
    return least;
  }
};

struct Less {
  ISIMP_KERNEL float operator()(float a, float b) const { return b < a ? b : a; }
};

/// The queues of a surface, which its floodings share.
class Queue {
 public:
  Queue(Memory& memory, std::int32_t faces)
      : even_(memory),
        odd_(memory),
        chosen_(memory),
        mark_(memory, static_cast<std::size_t>(faces)),
        progress_(memory, 1) {
    set_all(mark_, 0);
  }

  /// Floods from the seeds.
  /// \return the steps
  std::int32_t flood(const View& view, std::int32_t seeds, Job& job) {
    return run<AroundSeeds, false>(view, seeds, kNoOffer, job);
  }
  /// Floods the free faces with errors up to a level.
  std::int32_t fill(const View& view, float level, Job& job) {
    return run<FreeFaces, true>(view, view.count, level, job);
  }

 private:
  template <class Source, bool kOnce>
  std::int32_t run(const View& view, std::int64_t sources, float level, Job& job) {
    for (Array<std::int32_t>* array : {&even_, &odd_, &chosen_}) array->resize(mark_.size());
    Progress progress{};
    progress_.assign(&progress, 1);
    const Flood<kOnce> flood{view, even_.data(), odd_.data(), chosen_.data(), mark_.data(), progress_.data(), level};
    const std::int32_t first = ++step_;
    gather(Source{flood, first}, sources);
    do {
      job.poll();
      repeat(flood, step_);
      progress_.read(&progress, 1);
      step_ += progress.steps;
    } while (progress.size[step_ % 3] > 0);
    return step_ - first;
  }

  Array<std::int32_t> even_, odd_, chosen_, mark_;
  Array<Progress> progress_;
  std::int32_t step_ = 0;
};

}  // namespace isimp::parallel::ISIMP_DEVICE
