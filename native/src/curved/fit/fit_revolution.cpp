#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fit/fit.h"
#include "fit/numbers.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"
#include "isimp/core/to_integer.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr std::size_t kPointsABin = 3;  ///< at the least: a profile through every point fits anything
constexpr double kCluster = 1.0 / 80;   ///< share of the profile's size: points at a smaller distance are merged
constexpr double kTurns = 4;            ///< by how much a difference of normals lengthens a step
constexpr double kGap = 8;              ///< median steps: ends that are nearer make a ring
constexpr double kStraight = 0.02;      ///< share of its length: a run of corners no further from its chord is straight

/// Points of a profile that nearly coincide.
struct Cluster {
  Vec2 place = Vec2::Zero(), normal = Vec2::Zero();
  double weight = 0;
  std::vector<std::size_t> samples;
};

struct Half {  // half of a plane through the axis
  std::vector<Vec2> place, normal;
};

Half half_plane(const CurvedSurface& surface, const Samples& s) {
  Half h;
  h.place.reserve(s.size());
  h.normal.reserve(s.size());
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Polar p = polar(surface, s.place[i]);
    const Vec2 m(s.normal[i].dot(p.out), s.normal[i].dot(p.up));
    h.place.emplace_back(p.rho, p.z);
    h.normal.emplace_back(m / std::max(m.norm(), kTiny));
  }
  return h;
}

std::vector<Cluster> clusters_of(const Half& h, const Samples& s) {
  Vec2 low = h.place[0], high = h.place[0];
  for (const Vec2& p : h.place) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double radius = kCluster * (high - low).norm();
  std::vector<Cluster> all;
  std::vector<Vec2> place;  // by cluster
  for (std::size_t i = 0; i < s.size(); ++i) {
    std::size_t best = place.size();
    double least = radius;
    for (std::size_t k = 0; k < place.size(); ++k) {
      const double d = (place[k] - h.place[i]).norm();
      if (d >= least) continue;
      least = d;
      best = k;
    }
    if (best == place.size()) {
      all.emplace_back();
      place.emplace_back(Vec2::Zero());
    }
    Cluster& c = all[best];
    const double w = std::max(s.weight[i], kTiny);
    place[best] = (c.weight * place[best] + w * h.place[i]) / (c.weight + w);
    c.normal += w * h.normal[i];
    c.weight += w;
    c.samples.push_back(i);
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].place = place[k];
    all[k].normal.normalize();
  }
  return all;
}

/// The shortest tree over the clusters, as lists of neighbours.
std::vector<std::vector<std::size_t>> shortest_tree(const std::vector<Cluster>& all) {
  std::vector<std::vector<std::size_t>> tree(all.size());
  std::vector<double> to(all.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(all.size(), 0);
  std::vector<std::size_t> left(all.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::size_t at = 0;
  while (left.size() > 1) {
    left.erase(std::lower_bound(left.begin(), left.end(), at));
    std::size_t next = left[0];
    for (const std::size_t j : left) {
      const double d = (all[at].place - all[j].place).norm() * (1 + kTurns * (1 - all[at].normal.dot(all[j].normal)));
      if (d < to[j]) {
        to[j] = d;
        from[j] = at;
      }
      if (to[j] < to[next]) next = j;
    }
    tree[next].push_back(from[next]);
    tree[from[next]].push_back(next);
    at = next;
  }
  return tree;
}

/// Distances over the tree from one cluster, and the cluster before each.
struct Walk {
  std::vector<double> distance;
  std::vector<std::size_t> before, order;
};

Walk walk(const std::vector<Cluster>& all, const std::vector<std::vector<std::size_t>>& tree, std::size_t start) {
  Walk w{std::vector<double>(all.size(), -1), std::vector<std::size_t>(all.size(), start), {start}};
  w.distance[start] = 0;
  for (std::size_t k = 0; k < w.order.size(); ++k) {
    const std::size_t i = w.order[k];
    for (const std::size_t j : tree[i]) {
      if (w.distance[j] >= 0) continue;
      w.distance[j] = w.distance[i] + (all[i].place - all[j].place).norm();
      w.before[j] = i;
      w.order.push_back(j);
    }
  }
  return w;
}

/// The clusters in order along the longest path of the tree; one off the path comes at the place where it branches.
std::vector<std::size_t> in_order(const std::vector<Cluster>& all) {
  const auto tree = shortest_tree(all);
  const auto furthest = [](const Walk& w) {
    return static_cast<std::size_t>(std::max_element(w.distance.begin(), w.distance.end()) - w.distance.begin());
  };
  const std::size_t begin = furthest(walk(all, tree, 0));
  const Walk w = walk(all, tree, begin);
  std::vector<bool> is_on(all.size(), false);
  for (std::size_t i = furthest(w);; i = w.before[i]) {
    is_on[i] = true;
    if (i == begin) break;
  }
  std::vector<double> place(all.size(), 0.0);
  for (const std::size_t i : w.order) place[i] = is_on[i] ? w.distance[i] : place[w.before[i]];
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::pair(place[a], a) < std::pair(place[b], b); });
  return order;
}

struct Bin {
  Vec2 place, normal;
};

std::vector<Bin> bins_of(const Half& h, const Samples& s, std::size_t most) {
  const std::vector<Cluster> all = clusters_of(h, s);
  if (all.size() < 3) return {};
  std::vector<std::size_t> order;
  for (const std::size_t c : in_order(all)) order.insert(order.end(), all[c].samples.begin(), all[c].samples.end());
  double total = 0;
  for (const double w : s.weight) total += std::sqrt(w);
  const auto count = static_cast<double>(std::min(most, s.size() / kPointsABin));
  std::vector<Bin> bins;
  double done = 0, weight = 0;
  int last = -1;
  for (const std::size_t i : order) {
    const int bin = to_integer(count * done / total, 0, static_cast<int>(count));
    done += std::sqrt(s.weight[i]);
    if (bin != last) {
      bins.push_back({Vec2::Zero(), Vec2::Zero()});
      weight = 0;
      last = bin;
    }
    const double w = std::max(s.weight[i], kTiny);
    Bin& b = bins.back();
    b.place = (weight * b.place + w * h.place[i]) / (weight + w);
    b.normal += w * h.normal[i];
    weight += w;
  }
  for (Bin& b : bins) b.normal /= std::max(b.normal.norm(), kTiny);
  return bins;
}

/// The straight run from the first corner: the last one of it.
Vec2 straight_from(const std::vector<Vec2>& corners) {
  std::size_t end = 1;
  for (std::size_t k = 2; k < corners.size(); ++k) {
    const Vec2 chord = corners[k] - corners[0], normal(chord.y(), -chord.x());
    for (std::size_t i = 1; i < k; ++i)
      if (std::abs(normal.dot(corners[i] - corners[0])) > kStraight * chord.squaredNorm()) return corners[end];
    end = k;
  }
  return corners[end];
}

bool is_ring(const std::vector<Bin>& bins) {
  if (bins.size() <= 12) return false;
  std::vector<double> steps;
  for (std::size_t i = 1; i < bins.size(); ++i) steps.push_back((bins[i].place - bins[i - 1].place).norm());
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double gap = (bins.front().place - bins.back().place).norm();
  return gap < kGap * steps[steps.size() / 2] && bins.front().normal.dot(bins.back().normal) > 0.5;
}

}  // namespace

std::optional<CurvedSurface> with_profile(CurvedSurface surface, const Samples& samples) {
  const bool is_extrusion = surface.kind == CurvedKind::extrusion;
  const std::vector<Bin> bins = bins_of(half_plane(surface, samples), samples, is_extrusion ? kMostStrips : kCorners);
  if (bins.size() < 3) return std::nullopt;
  surface.closed = is_ring(bins);
  std::vector<Vec2> corners;
  corners.reserve(bins.size());
  for (const Bin& b : bins) corners.push_back(b.place);
  if (!surface.closed) {
    const auto beyond = [&](const Vec2& end, const Vec2& inner) {
      Vec2 step = 0.5 * (end - inner);
      if (!is_extrusion && step.x() < -end.x()) step *= -end.x() / step.x();  // to the axis
      Vec2 p = end + step;
      if (!is_extrusion) p.x() = std::max(p.x(), 0.0);
      return p;
    };
    // The corners are centres of points, which may all lie in the middle of a cylinder.
    const Vec2 first = beyond(corners.front(), straight_from(corners));
    std::reverse(corners.begin(), corners.end());
    const Vec2 last = beyond(corners.front(), straight_from(corners));
    std::reverse(corners.begin(), corners.end());
    corners.insert(corners.begin(), first);
    corners.push_back(last);
  }
  double turn = 0;
  const std::size_t shift = surface.closed ? 0 : 1;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const Vec2 t = corners[(i + shift + 1) % corners.size()] - corners[i + shift];
    turn += bins[i].normal.dot(Vec2(t.y(), -t.x()));
  }
  surface.side = turn < 0 ? -1 : 1;
  surface.profile.clear();
  surface.radius = 0;
  for (const Vec2& c : corners) {
    surface.profile.insert(surface.profile.end(), {c.x(), c.y()});
    surface.radius = std::max(surface.radius, is_extrusion ? c.norm() : c.x());
  }
  return surface;
}

std::optional<CurvedSurface> fit_revolution(const Samples& s) {
  Vec3 centre = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) centre += s.weight[i] * s.place[i];
  double size = 0;
  for (std::size_t i = 0; i < s.size(); ++i) size += s.weight[i] * (s.place[i] - centre).squaredNorm();
  size = std::sqrt(size);
  if (!(size > 0)) return std::nullopt;
  Eigen::Matrix3d nn = Eigen::Matrix3d::Zero(), mm = nn, nm = nn;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Vec3 &n = s.normal[i], m = ((s.place[i] - centre) / size).cross(n);
    nn += s.weight[i] * n * n.transpose();
    mm += s.weight[i] * m * m.transpose();
    nm += s.weight[i] * n * m.transpose();
  }
  const auto [spread, e] = spectrum_of(nn);
  Vec3 inverse = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (spread[k] > kSpeck) inverse[k] = 1 / spread[k];
  const Eigen::Matrix3d g = -(e * inverse.asDiagonal() * e.transpose()) * nm;
  Eigen::Matrix3d left = mm + nm.transpose() * g;
  left = (left + left.transpose()).eval() / 2;
  CurvedSurface c;
  c.kind = CurvedKind::revolution;
  c.axis = spectrum_of(left).vectors.col(0);
  const Vec3 moment = g * c.axis;
  c.point = centre + size * c.axis.cross(moment - moment.dot(c.axis) * c.axis);
  return with_profile(std::move(c), s);
}

}  // namespace isimp::curved
