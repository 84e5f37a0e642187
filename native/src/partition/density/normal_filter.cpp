// Zheng, Fu, Au, Tai: Bilateral normal filtering for mesh denoising, 2011.

#include "density/normal_filter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isimp {
namespace {

// tuned houses
constexpr double kBlind = 1.0;  // from this range on the normals of a house's roof and wall mix

float difference(const FaceRecord& a, const FaceRecord& b) {
  const float x = a.nx - b.nx, y = a.ny - b.ny, z = a.nz - b.nz;
  return x * x + y * y + z * z;
}

double median_difference(const FaceGraph& graph, const Array<FaceRecord>& faces) {
  std::vector<float> bends;
  bends.reserve(static_cast<std::size_t>(graph.size()) * 3 / 2);
  for (std::int32_t i = 0; i < graph.size(); ++i)
    for (const std::int32_t j : graph.neighbours[i])
      if (j > i && j != graph.size()) bends.push_back(difference(faces[i], faces[j]));
  if (bends.empty()) return 0.0;
  const auto middle = bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2);
  std::nth_element(bends.begin(), middle, bends.end());
  return std::sqrt(static_cast<double>(*middle));
}

}  // namespace

double median_bend(const FaceGraph& graph) { return median_difference(graph, graph.faces); }

Array<FaceRecord> filtered_faces(const FaceGraph& graph, int passes, double range, const Threads& threads, Job& job) {
  Array<FaceRecord> now = graph.faces, next = graph.faces;
  const std::int32_t n = graph.size();
  for (int pass = 0; pass < passes; ++pass) {
    job.report(static_cast<double>(pass) / passes);
    if (range > kBlind && pass == passes / 2) range = std::min(range, filter_range(median_difference(graph, now)));
    const auto sharpness = static_cast<float>(-1 / (2 * range * range));
    threads.run(n, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      for (std::int32_t i = begin; i < end; ++i) {
        if ((i & 0xffff) == 0) job.poll();
        const FaceRecord& f = now[i];
        float x = f.area * f.nx, y = f.area * f.ny, z = f.area * f.nz;
        for (const std::int32_t j : graph.neighbours[i]) {  // the sentinel has no area
          const FaceRecord& g = now[j];
          const float weight = g.area * std::exp(difference(f, g) * sharpness);
          x += weight * g.nx;
          y += weight * g.ny;
          z += weight * g.nz;
        }
        const float length = std::sqrt(x * x + y * y + z * z);
        next[i] = length > 0 ? FaceRecord{x / length, y / length, z / length, f.area} : f;
      }
    });
    now.swap(next);
  }
  return now;
}

}  // namespace isimp
