#include "complex/raggedness.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isimp::meshing {
namespace {

// tuned real
constexpr int kWindows = 16;               // least number per loop: a square has its corners in a quarter of them
constexpr double kOfRagged = 2.0;          // times the raggedness: the reach
constexpr double kRoundingLength = 1e-12;  // rounding: share of the diagonal
constexpr double kRagged = 0.8;  // mean edges of the border: one that is more ragged is straightened by itself

/// The closed lines of the border, faces in no region left out.
std::vector<std::vector<Vec3>> border_lines(const Mesh& mesh, std::span<const std::int32_t> face_region) {
  std::vector<std::vector<Vec3>> lines;
  std::vector<bool> seen(mesh.opposite().size(), false);
  for (std::size_t start = 0; start < seen.size(); ++start) {
    auto h = static_cast<std::int32_t>(start);
    if (mesh.opposite(h) != kNone || seen[start] || face_region[h / 3] == kNone) continue;
    std::vector<Vec3>& line = lines.emplace_back();
    for (; !seen[h]; h = mesh.vertex_halfedge()[mesh.to(h)]) {
      seen[h] = true;
      line.push_back(mesh.vertices()[mesh.from(h)]);
    }
    line.push_back(line.front());
  }
  return lines;
}

double mean_border_edge(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.opposite().size(); ++i) {
    const auto h = static_cast<std::int32_t>(i);
    if (mesh.opposite(h) == kNone) sum += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
  }
  return sum / static_cast<double>(mesh.report().border_edges);
}

/// The largest distance of points at equal steps from the parabola that fits them best.
double off_parabola(const std::array<Vec3, kSamples>& points) {
  // Polynomials that are orthogonal on these places.
  double square = 0;
  const auto place = [](int i) { return 2.0 * i / (kSamples - 1) - 1.0; };
  for (int i = 0; i < kSamples; ++i) square += place(i) * place(i) / kSamples;
  std::array<Vec3, 3> coefficient{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<double, 3> norm{};
  const auto basis = [&](int k, double t) { return k == 0 ? 1.0 : k == 1 ? t : t * t - square; };
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < kSamples; ++i) {
      coefficient[k] += basis(k, place(i)) * points[i];
      norm[k] += basis(k, place(i)) * basis(k, place(i));
    }
    coefficient[k] /= norm[k];
  }
  double most = 0;
  for (int i = 0; i < kSamples; ++i) {
    Vec3 d = points[i];
    for (int k = 0; k < 3; ++k) d -= basis(k, place(i)) * coefficient[k];
    most = std::max(most, d.norm());
  }
  return most;
}

}  // namespace

double raggedness(const Mesh& mesh, std::span<const std::int32_t> face_region, double window) {
  struct Window {
    double off, length;
  };
  std::vector<Window> windows;
  double all = 0;
  for (const std::vector<Vec3>& line : border_lines(mesh, face_region)) {
    const Along along(line);
    if (!(along.length() >= 2 * window) || !std::isfinite(along.length())) continue;
    // No shorter than an edge: regions without area have a window of no length.
    const double edge = along.length() / static_cast<double>(line.size() - 1);
    const double length = std::min(std::max(window, edge), along.length() / kWindows);
    for (double begin = 0; begin < along.length(); begin += length / 2) {
      std::array<Vec3, kSamples> points;
      for (int i = 0; i < kSamples; ++i) points[i] = along.at(begin + length * i / (kSamples - 1));
      windows.push_back({off_parabola(points), length});
      all += length;
    }
  }
  // By length, since a loop has a least number of windows: else small holes would outvote a long border.
  std::sort(windows.begin(), windows.end(), [](const Window& a, const Window& b) { return a.off < b.off; });
  double sum = 0;
  for (const Window& w : windows)
    if ((sum += w.length) >= all / 2) return w.off;
  return 0;
}

double rim_reach(const Mesh& mesh, const Partition& partition, const MeshingOptions& options, double window) {
  if (mesh.report().border_loops == 0) return 0;
  if (options.straight_rims)  // a length that rounding would hide counts as none
    return *options.straight_rims > kRoundingLength * mesh.diagonal() ? *options.straight_rims : 0.0;
  const double ragged = raggedness(mesh, partition.face_region, window);
  return ragged > kRagged * mean_border_edge(mesh) ? kOfRagged * ragged : 0.0;
}

}  // namespace isimp::meshing
