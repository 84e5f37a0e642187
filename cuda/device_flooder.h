#pragma once

#include <thrust/functional.h>
#include <thrust/system_error.h>

#include <algorithm>
#include <bit>
#include <cuda/std/bit>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "flooding.h"
#include "isimp/core/errors.h"
#include "isimp/parallel/backend.h"
#include "isimp/parallel/flooder.h"
#include "nearest.h"
#include "pieces.h"
#include "summing.h"

namespace isimp::parallel::ISIMP_DEVICE {

/// Runs work on the device; its errors become the engine's.
template <class Work>
auto guarded(const char* what, std::size_t faces, Work work) {
  try {
    return work();
  } catch (const OutOfMemory& e) {
    throw Error(out_of_memory(kName, what, faces, e.wanted, e.held));
  } catch (const thrust::system_error& e) {
    throw Error(out_of_order(kName, what, faces, e.what()));
  }
}

/// Stores the least of (error, face) for each region; a run of faces is merged first where they share a region.
struct NearestOfRun {
  static constexpr std::int64_t kRun = 16;
  using Key = unsigned long long;  // the bits of the error, which rise with it, then the face

  View view;
  Key* nearest;  ///< (R)

  ISIMP_KERNEL void operator()(std::int64_t run) const {
    const std::int64_t end = (run + 1) * kRun < view.count ? (run + 1) * kRun : view.count;
    std::int32_t region = -1;
    Key least = ~Key{0};
    for (std::int64_t i = run * kRun; i < end; ++i) {
      const std::int32_t r = view.label[i];
      if (r < 0) continue;
      if (r != region) {
        put(region, least);
        region = r;
        least = ~Key{0};
      }
      const float error = view.error(static_cast<std::int32_t>(i), r);
      const Key key = static_cast<Key>(cuda::std::bit_cast<std::uint32_t>(error)) << 32 | static_cast<Key>(i);
      if (key < least) least = key;
    }
    put(region, least);
  }
  ISIMP_KERNEL void put(std::int32_t region, Key least) const {
    if (region >= 0) shared(nearest[region]).fetch_min(least, kRelaxed);
  }
};

struct LabelSeeds {
  View view;
  ISIMP_KERNEL void operator()(std::int64_t r) const { view.label[view.seed[r]] = static_cast<std::int32_t>(r); }
};

/// The memory that a surface takes on the device, and the steps on it.
class DeviceFlooder final : public Flooder {
  template <class Work>
  auto work(const char* what, std::int32_t threads, Work run) {
    const Threads limit(threads);
    return guarded(what, static_cast<std::size_t>(count_), run);
  }

  /// Copies the proxies to the device.
  /// \param anew  every face except the seeds is free
  View begin(const Proxies& proxies, bool anew) {
    regions_ = static_cast<std::int32_t>(proxies.seed.size());
    seed_.assign(proxies.seed.data(), proxies.seed.size());
    normal_.assign(reinterpret_cast<const Normal*>(proxies.normal.data()), proxies.seed.size());
    const View view{faces_.data(), neighbours_.data(), normal_.data(), seed_.data(), label_.data(), count_};
    if (anew) {
      set_all(label_, -1);
      for_all(0, regions_, LabelSeeds{view});
    }
    return view;
  }

  template <int kColumns>
  Fit fit_columns() {
    const std::vector<double> sums =
        sum_up<kColumns>(memory_, faces_.data(), place_.data(), label_.data(), count_, regions_, shift_);
    Fit fit;
    for (std::size_t at = 0; at < sums.size(); at += kColumns) {
      fit.sum.push_back({sums[at], sums[at + 1], sums[at + 2], sums[at + 3]});
      if constexpr (kColumns == 7) fit.centre.push_back({sums[at + 4], sums[at + 5], sums[at + 6]});
    }
    return fit;
  }

  std::vector<std::int32_t> seeds_in_components(const Proxies& proxies) const {
    std::vector<std::int32_t> seeds(1, 0);
    if (!host_component_.empty())
      seeds.resize(static_cast<std::size_t>(*std::max_element(host_component_.begin(), host_component_.end())) + 1, 0);
    if (!host_component_.empty())
      for (const std::int32_t seed : proxies.seed) ++seeds[static_cast<std::size_t>(host_component_[seed])];
    return seeds;
  }

 public:
  DeviceFlooder(const FloodSurface& surface, std::size_t most)
      : count_(static_cast<std::int32_t>(surface.faces.size() / 4)),
        memory_(most),
        faces_(memory_, surface.faces),
        neighbours_(memory_, surface.neighbours),
        label_(memory_, static_cast<std::size_t>(count_) + 1),
        kept_(memory_),
        seed_(memory_),
        component_(memory_),
        normal_(memory_),
        place_(memory_),
        queue_(memory_, count_) {
    set_all(label_, -1);
    const Survey found = survey(memory_, faces_.data(), nullptr, count_, 0);
    if (found.first_bad < count_) throw InvalidInput(complaint(found.first_bad, &surface.faces[4 * found.first_bad]));
    shift_ = shift_for(found.largest_area, count_);
  }

  void place(std::span<const float> centre, std::span<const std::int32_t> component) override {
    guarded("placing", static_cast<std::size_t>(count_), [&] {
      component_.assign(component.data(), component.size());
      place_.assign(centre.data(), centre.size());
      host_component_.assign(component.begin(), component.end());
    });
  }
  [[nodiscard]] bool placed() const override { return !place_.empty(); }

  std::int32_t queued(const Proxies& proxies, std::int32_t threads, Job& job) override {
    return work("flooding", threads, [&] {
      const View view = begin(proxies, true);
      return queue_.flood(view, regions_, job);
    });
  }

  void naive(const Proxies& proxies, std::int32_t nearest, bool brute, std::int32_t threads, Job& job) override {
    if (!placed()) throw InvalidInput("naive flooding wants the faces placed");
    if (nearest < 1 || nearest > kMostNearest)
      throw InvalidInput("nearest must be in [1, " + std::to_string(kMostNearest) + "], got " +
                         std::to_string(nearest));
    work("flooding", threads, [&] {
      const View view = begin(proxies, true);
      const auto* centre = reinterpret_cast<const Normal*>(proxies.centre.data());
      const HostGrid host(proxies.centre);
      const Readable<Normal> centres(memory_, {centre, proxies.seed.size()});
      const std::vector<std::int32_t> host_in_component = seeds_in_components(proxies);
      const Readable<std::int32_t> start(memory_, host.start), region(memory_, host.region),
          in_component(memory_, host_in_component);
      const Grid grid{brute ? nullptr : start.data(), region.data(), host.side};
      const ChooseNear choose{view,     place_.data(), centres.data(), component_.data(), in_component.data(), nearest,
                              regions_, grid};
      const std::int64_t slice = std::max<std::int64_t>(1 << 10, (1 << 24) / (brute ? regions_ : 64));
      for (std::int64_t i = 0; i < count_; i += slice) {
        job.poll();
        for_all(i, std::min<std::int64_t>(i + slice, count_), choose);
      }
    });
  }

  [[nodiscard]] Fit fit(std::int32_t threads) override {
    return work("fitting", threads, [&] { return placed() ? fit_columns<7>() : fit_columns<4>(); });
  }

  [[nodiscard]] std::vector<std::int32_t> nearest_faces(const Proxies& proxies, std::int32_t threads) override {
    return work("fitting", threads, [&] {
      const View view = begin(proxies, false);
      using Key = NearestOfRun::Key;
      Array<Key> keys(memory_, static_cast<std::size_t>(regions_));
      set_all(keys, ~Key{0});
      for_all(0, (count_ + NearestOfRun::kRun - 1) / NearestOfRun::kRun, NearestOfRun{view, keys.data()});
      const std::vector<Key> host = keys.read();
      std::vector<std::int32_t> faces(host.size());
      for (std::size_t r = 0; r < faces.size(); ++r) faces[r] = static_cast<std::int32_t>(host[r] & 0xffffffffU);
      return faces;
    });
  }

  void keep() override {
    guarded("keeping", static_cast<std::size_t>(count_), [&] { kept_.assign(label_.data(), label_.size()); });
  }
  void go_back() override { label_.swap(kept_); }

  std::int32_t cut_to_pieces(std::int32_t threads, Job& job) override {
    return work("joining", threads, [&] {
      const auto faces = static_cast<std::size_t>(count_);
      const auto regions = static_cast<std::size_t>(regions_);
      const View view{faces_.data(), neighbours_.data(), nullptr, nullptr, label_.data(), count_};
      Array<std::int32_t> parent(memory_, faces), root(memory_, faces), first(memory_, regions);
      Array<Integer> area(memory_, faces), largest(memory_, regions);
      set_all(first, std::numeric_limits<std::int32_t>::max());
      set_all(area, Integer{0});
      set_all(largest, Integer{-1});
      for_all(0, count_, Alone{parent.data()});
      const Join join{view, parent.data()};
      for_all(0, count_, join);
      job.poll();
      for_all(0, count_, Flatten{join, faces_.data(), std::ldexp(1.0, shift_), root.data(), area.data()});
      const LargestPiece find{view, root.data(), area.data(), largest.data()};
      for_all(0, count_, find);
      for_all(0, count_, FirstOfLargest{find, first.data()});
      return reduce_all(memory_, count_, FreeOthers{view, root.data(), first.data()}, 0, thrust::plus<std::int32_t>());
    });
  }

  std::int32_t fill(const Proxies& proxies, std::int32_t threads, Job& job) override {
    return work("filling", threads, [&] {
      const View view = begin(proxies, false);
      std::int32_t steps = 0;
      for (float level = 0;;) {
        const float least = reduce_all(memory_, count_, LeastOffer{view}, kNoOffer, Less{});
        if (!(least > level && least < kNoOffer)) return steps;
        level = end_of_level(least);
        steps += queue_.fill(view, level, job);
      }
    });
  }

  void labels(std::span<std::int32_t> labels) const override {
    guarded("reading", static_cast<std::size_t>(count_),
            [&] { label_.read(labels.data(), static_cast<std::size_t>(count_)); });
  }

  [[nodiscard]] MemoryUse memory() const override { return {memory_.held(), memory_.allocations()}; }

 private:
  /// The largest float of an error's quarter octave.
  static float end_of_level(float error) {
    constexpr std::uint32_t kRest = (1U << 21) - 1;  // all but two of the 23 bits of mantissa
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(error) | kRest);
  }

  std::int32_t count_, regions_ = 0;
  int shift_ = 0;
  Memory memory_;  // first, since the next ones allocate from it
  Readable<float> faces_;
  Readable<std::int32_t> neighbours_;
  Array<std::int32_t> label_, kept_, seed_, component_;
  Array<Normal> normal_;
  Array<float> place_;
  std::vector<std::int32_t> host_component_;
  Queue queue_;
};

/// \throws InvalidInput  as Kernels::load
inline std::unique_ptr<Flooder> load_flooder(const FloodSurface& surface, std::size_t most) {
  const auto count = static_cast<std::int64_t>(surface.faces.size() / 4);
  if (surface.faces.size() % 4 != 0 || surface.neighbours.size() != 3 * static_cast<std::size_t>(count))
    throw InvalidInput("flooding wants 4 numbers and 3 neighbours a face, but got " +
                       std::to_string(surface.faces.size()) + " and " + std::to_string(surface.neighbours.size()));
  for (std::size_t h = 0; h < surface.neighbours.size(); ++h)
    if (surface.neighbours[h] < 0 || surface.neighbours[h] > count)
      throw InvalidInput("face " + std::to_string(h / 3) + " has neighbour " + std::to_string(surface.neighbours[h]) +
                         ", but there are " + std::to_string(count) + " faces");
  return std::make_unique<DeviceFlooder>(surface, most);
}

}  // namespace isimp::parallel::ISIMP_DEVICE
