#include "parallel_lloyd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "flooding.h"
#include "isimp/core/check.h"
#include "isimp/parallel/backend.h"
#include "isimp/partition/metric.h"

namespace isimp {
namespace {

using Point = std::array<float, 3>;

/// The middle of faces as naive flooding measures: in the unit of the longest side of the box.
class Middles {
 public:
  explicit Middles(const Surface& surface) : surface_(surface) {
    Box box;
    for (const Vec3& v : surface.mesh().vertices()) box.extend(v);
    low_ = box.min();
    const double longest = box.sizes().maxCoeff();
    if (longest > 0) scale_ = 1.0 / longest;
  }
  [[nodiscard]] Point of(std::int32_t graph_index) const {
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t v : surface_.mesh().triangles()[surface_.graph().mesh_face[graph_index]])
      sum += (surface_.mesh().vertices()[v] - low_) * (scale_ / 3.0);
    return {static_cast<float>(sum.x()), static_cast<float>(sum.y()), static_cast<float>(sum.z())};
  }

 private:
  const Surface& surface_;
  Vec3 low_;
  double scale_ = 0.0;
};

void put(std::vector<float>& points, std::size_t r, const Point& p) {
  for (std::size_t k = 0; k < 3; ++k) points[3 * r + k] = p[k];
}

void place(const Surface& surface, parallel::Flooder& flooder) {
  const auto faces = static_cast<std::size_t>(surface.graph().size());
  std::vector<float> centre(3 * faces);
  std::vector<std::int32_t> component(surface.component_count() > 1 ? faces : 0);
  const Middles middles(surface);
  for (std::size_t i = 0; i < faces; ++i) {
    put(centre, i, middles.of(static_cast<std::int32_t>(i)));
    if (!component.empty()) component[i] = surface.component()[surface.graph().mesh_face[i]];
  }
  flooder.place(centre, component);
}

/// The normals that fit the sums, with their seeds and centres; a region without area keeps its old ones. Roots and
/// quotients are taken here and nowhere else, so that they are the same for every back end.
parallel::Proxies refit(const parallel::Flooder::Fit& fit, parallel::Proxies proxies) {
  ISIMP_ASSERT(proxies.normal.size() == 3 * fit.sum.size(), "each proxy has a sum");
  for (std::size_t r = 0; r < fit.sum.size(); ++r) {
    const auto& [area, x, y, z] = fit.sum[r];
    const double length = std::sqrt(x * x + y * y + z * z);
    const auto share = [](double a, double b) { return static_cast<float>(a / b); };
    if (length > 0) put(proxies.normal, r, {share(x, length), share(y, length), share(z, length)});
    if (fit.centre.empty() || !(area > 0)) continue;
    const auto& c = fit.centre[r];
    put(proxies.centre, r, {share(c[0], area), share(c[1], area), share(c[2], area)});
  }
  return proxies;
}

double error_of(const parallel::Flooder::Fit& fit) {
  double error = 0.0;
  for (const auto& [area, x, y, z] : fit.sum) error += std::max(0.0, 2 * (area - std::sqrt(x * x + y * y + z * z)));
  return error;
}

parallel::Proxies first_proxies(const Surface& surface, std::vector<std::int32_t> seeds) {
  parallel::Proxies proxies;
  proxies.normal.resize(3 * seeds.size());
  proxies.centre.resize(3 * seeds.size());
  const Middles middles(surface);
  for (std::size_t r = 0; r < seeds.size(); ++r) {
    const FaceRecord& f = surface.graph().faces[seeds[r]];
    put(proxies.normal, r, {f.nx, f.ny, f.nz});
    put(proxies.centre, r, middles.of(seeds[r]));
  }
  proxies.seed = std::move(seeds);
  return proxies;
}

/// One more sequential round, from the fitted seeds: the last round of the thesis.
Regions flood_again(const FaceGraph& graph, const parallel::Proxies& proxies, Job& job) {
  std::vector<NormalMetric::Proxy> normals(proxies.seed.size());
  for (std::size_t r = 0; r < normals.size(); ++r)
    normals[r] = {proxies.normal[3 * r], proxies.normal[3 * r + 1], proxies.normal[3 * r + 2]};
  Regions regions;
  Flooding().run(graph, normals, proxies.seed, regions.label, job);
  return regions;
}

/// Every region keeps its largest piece, is fitted again, and the faces between are flooded from there.
Regions repair(const FaceGraph& graph, parallel::Flooder& flooder, parallel::Proxies proxies, std::int32_t threads,
               Job& job) {
  flooder.cut_to_pieces(threads, job);
  proxies = refit(flooder.fit(threads), std::move(proxies));
  flooder.fill(proxies, threads, job);
  Regions regions;
  regions.label.assign(static_cast<std::size_t>(graph.size()) + 1, kNone);
  flooder.labels(std::span(regions.label).first(static_cast<std::size_t>(graph.size())));
  return regions;
}

}  // namespace

std::unique_ptr<parallel::Flooder> load(const Surface& surface, std::string_view backend) {
  const FaceGraph& graph = surface.graph();
  static_assert(sizeof(FaceRecord) == 4 * sizeof(float) && sizeof(graph.neighbours[0]) == 3 * sizeof(std::int32_t));
  const auto faces = static_cast<std::size_t>(graph.size());
  return parallel::backend(backend).load(
      {{&graph.faces.data()->nx, 4 * faces}, {graph.neighbours.data()->data(), 3 * faces}});
}

Regions parallel_lloyd(const Surface& surface, parallel::Flooder& flooder, std::vector<std::int32_t> seeds,
                       const PartitionOptions& options, std::vector<double>& history, Job& job) {
  const bool naive = options.method == Method::naive;
  if (naive && !flooder.placed()) place(surface, flooder);
  parallel::Proxies proxies = first_proxies(surface, std::move(seeds)), best;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t round = 0; round < options.iterations; ++round) {
    job.report(static_cast<double>(round) / (options.iterations + 1));
    if (naive) {
      flooder.naive(proxies, options.nearest, options.search == Search::brute, options.threads, job);
    } else {
      flooder.queued(proxies, options.threads, job);
    }
    parallel::Flooder::Fit fit = flooder.fit(options.threads);
    if (!naive) fit.centre.clear();  // a kept flooder has places from an earlier call, which must not count here
    parallel::Proxies next = refit(fit, proxies);
    next.seed = flooder.nearest_faces(next, options.threads);
    history.push_back(error_of(fit));
    if (history.back() < least) {
      least = history.back();
      best = next;
      flooder.keep();
    }
    if (next == proxies) break;  // the same labels would repeat for ever
    proxies = std::move(next);
  }
  flooder.go_back();
  Regions regions = options.connect == Connect::flood ? flood_again(surface.graph(), best, job)
                                                      : repair(surface.graph(), flooder, best, options.threads, job);
  regions.sum.resize(best.seed.size());
  sum_regions(surface.graph(), regions, job);
  history.push_back(regions.error());
  return regions;
}

}  // namespace isimp
