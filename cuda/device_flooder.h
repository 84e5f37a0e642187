#pragma once

#include <thrust/copy.h>
#include <thrust/fill.h>
#include <thrust/sequence.h>
#include <thrust/system_error.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "flooding.h"
#include "isimp/core/errors.h"
#include "isimp/parallel/flooder.h"
#include "nearest.h"
#include "pieces.h"
#include "summing.h"

namespace isimp::parallel {

/// Does some work on the device; its failures become the engine's, in words.
template <class Work>
auto guarded(const char* what, std::size_t faces, Work work) {
  const std::string on = " on back end '" + std::string(kName) + "'";
  const std::string instead = std::string(kName) == "cpu" ? "" : "; back end 'cpu' can do the same in the main memory";
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw Error(std::string(what) + " " + std::to_string(faces) + " faces ran out of memory" + on + instead);
  } catch (const thrust::system_error& e) {
    throw Error(std::string(what) + " failed" + on + ": " + e.what() + instead);
  }
}

/// Keeps the least of (error, face) for each region; a run of faces goes out at once where they share a region.
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

/// The memory that a surface takes on the device, and the steps on it. A device_vector frees itself.
class DeviceFlooder final : public Flooder {
  template <class Work>
  auto work(const char* what, std::int32_t threads, Work run) {
    const Threads limit(threads);
    return guarded(what, static_cast<std::size_t>(count_), run);
  }

  /// Sends the proxies over. \param anew  every face is free but the seeds
  View begin(const Proxies& proxies, bool anew) {
    regions_ = static_cast<std::int32_t>(proxies.seed.size());
    seed_.assign(proxies.seed.begin(), proxies.seed.end());
    const auto* normal = reinterpret_cast<const Normal*>(proxies.normal.data());
    normal_.assign(normal, normal + regions_);
    const View view{faces_.data(), neighbours_.data(), raw(normal_), raw(seed_), raw(label_), count_};
    if (anew) {
      thrust::fill(label_.begin(), label_.end(), -1);
      for_all(0, regions_, LabelSeeds{view});
    }
    return view;
  }

  template <int kColumns>
  Fit fit_columns() {
    const std::vector<double> sums =
        sum_up<kColumns>(faces_.data(), placed() ? raw(place_) : nullptr, raw(label_), count_, regions_, shift_);
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
  explicit DeviceFlooder(const FloodSurface& surface)
      : count_(static_cast<std::int32_t>(surface.faces.size() / 4)),
        faces_(surface.faces),
        neighbours_(surface.neighbours),
        label_(static_cast<std::size_t>(count_) + 1, -1),
        queue_(count_) {
    const Survey found = survey(faces_.data(), nullptr, count_, 0);
    if (found.first_bad < count_) throw InvalidInput(complaint(found.first_bad, &surface.faces[4 * found.first_bad]));
    shift_ = shift_for(found.largest_area, count_);
  }

  void place(std::span<const float> centre, std::span<const std::int32_t> component) override {
    guarded("placing", static_cast<std::size_t>(count_), [&] {
      place_.assign(centre.begin(), centre.end());
      component_.assign(component.begin(), component.end());
      host_component_.assign(component.begin(), component.end());
    });
  }
  [[nodiscard]] bool placed() const override { return !place_.empty(); }

  std::int32_t queued(const Proxies& proxies, std::int32_t threads, Job& job) override {
    return work("flooding", threads, [&] {
      const View view = begin(proxies, true);
      queue_.start_around_seeds(view, regions_);
      std::int32_t steps = 0;
      for (; queue_.size() > 0; ++steps) {
        job.poll();
        for_all(0, queue_.size(), Choose{view, queue_.faces(), queue_.chosen()});
        queue_.advance(view);
      }
      return steps;
    });
  }

  void naive(const Proxies& proxies, std::int32_t nearest, Search search, std::int32_t threads, Job& job) override {
    if (!placed()) throw InvalidInput("naive flooding wants the faces placed");
    if (nearest < 1 || nearest > kMostNearest)
      throw InvalidInput("nearest must be in [1, " + std::to_string(kMostNearest) + "], got " +
                         std::to_string(nearest));
    work("flooding", threads, [&] {
      const View view = begin(proxies, true);
      const auto* centre = reinterpret_cast<const Normal*>(proxies.centre.data());
      const Array<Normal> centres(centre, centre + regions_);
      const HostGrid host(proxies.centre);
      const Array<std::int32_t> start(host.start), region(host.region), in_part(seeds_in_components(proxies));
      const bool brute = search == Search::brute;
      const Grid grid{brute ? nullptr : raw(start), raw(region), host.side};
      const ChooseNear choose{view,         raw(place_), raw(centres), component_.empty() ? nullptr : raw(component_),
                              raw(in_part), nearest,     regions_,     grid};
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
      Array<Key> keys(static_cast<std::size_t>(regions_), ~Key{0});
      for_all(0, (count_ + NearestOfRun::kRun - 1) / NearestOfRun::kRun, NearestOfRun{view, raw(keys)});
      std::vector<Key> host(keys.size());
      thrust::copy(keys.begin(), keys.end(), host.begin());
      std::vector<std::int32_t> faces(host.size());
      for (std::size_t r = 0; r < faces.size(); ++r) faces[r] = static_cast<std::int32_t>(host[r] & 0xffffffffU);
      return faces;
    });
  }

  void keep() override {
    guarded("keeping", static_cast<std::size_t>(count_), [&] { kept_ = label_; });
  }
  void go_back() override { label_.swap(kept_); }

  std::int32_t cut_to_pieces(std::int32_t threads, Job& job) override {
    return work("joining", threads, [&] {
      const auto faces = static_cast<std::size_t>(count_);
      const View view{faces_.data(), neighbours_.data(), nullptr, nullptr, raw(label_), count_};
      Array<std::int32_t> parent(faces), root(faces);
      Array<std::int32_t> first(static_cast<std::size_t>(regions_), std::numeric_limits<std::int32_t>::max());
      Array<Integer> area(faces, 0), largest(static_cast<std::size_t>(regions_), -1);
      thrust::sequence(parent.begin(), parent.end());
      const Join join{view, raw(parent)};
      for_all(0, count_, join);
      job.poll();
      for_all(0, count_, Flatten{join, faces_.data(), std::ldexp(1.0, shift_), raw(root), raw(area)});
      const LargestPiece find{view, raw(root), raw(area), raw(largest)};
      for_all(0, count_, find);
      for_all(0, count_, FirstOfLargest{find, raw(first)});
      return reduce_all(count_, FreeOthers{view, raw(root), raw(first)}, 0, thrust::plus<std::int32_t>());
    });
  }

  std::int32_t fill(const Proxies& proxies, std::int32_t threads, Job& job) override {
    return work("filling", threads, [&] {
      const View view = begin(proxies, false);
      queue_.start_free(view);
      std::int32_t steps = 0;
      for (float level = 0; queue_.size() > 0; ++steps) {
        job.poll();
        const float least = reduce_all(queue_.size(), LeastOffer{view, queue_.faces()}, kNoOffer, Less{});
        level = std::max(level, end_of_level(least));
        for_all(0, queue_.size(), ChooseOnce{view, queue_.faces(), queue_.chosen(), level});
        queue_.advance(view);
      }
      return steps;
    });
  }

  void labels(std::span<std::int32_t> labels) const override {
    guarded("reading", static_cast<std::size_t>(count_),
            [&] { thrust::copy(label_.begin(), label_.begin() + count_, labels.begin()); });
  }

 private:
  /// The largest float of an error's quarter octave.
  static float end_of_level(float error) {
    constexpr std::uint32_t kRest = (1U << 21) - 1;  // of the 23 bits of mantissa all but two
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(error) | kRest);
  }

  std::int32_t count_, regions_ = 0;
  int shift_ = 0;
  Readable<float> faces_;
  Readable<std::int32_t> neighbours_;
  Array<std::int32_t> label_, kept_, seed_, component_;
  Array<Normal> normal_;
  Array<float> place_;
  std::vector<std::int32_t> host_component_;
  Queue queue_;
};

/// \throws InvalidInput  as Kernels::load says
inline std::unique_ptr<Flooder> load_flooder(const FloodSurface& surface) {
  const auto count = static_cast<std::int64_t>(surface.faces.size() / 4);
  if (surface.faces.size() % 4 != 0 || surface.neighbours.size() != 3 * static_cast<std::size_t>(count))
    throw InvalidInput("flooding wants 4 numbers and 3 neighbours a face, but got " +
                       std::to_string(surface.faces.size()) + " and " + std::to_string(surface.neighbours.size()));
  for (std::size_t h = 0; h < surface.neighbours.size(); ++h)
    if (surface.neighbours[h] < 0 || surface.neighbours[h] > count)
      throw InvalidInput("face " + std::to_string(h / 3) + " has neighbour " + std::to_string(surface.neighbours[h]) +
                         ", but there are " + std::to_string(count) + " faces");
  return std::make_unique<DeviceFlooder>(surface);
}

}  // namespace isimp::parallel
