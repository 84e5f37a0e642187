#include "isimp/simplify/mirror.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>
#include <vector>

#include "closest_faces.h"
#include "density/noise.h"
#include "isimp/core/balanced.h"
#include "isimp/core/errors.h"
#include "isimp/core/threads.h"

namespace isimp {
namespace {

constexpr double kDamping = 1e-9;  ///< share of the diagonal: a plane that fits equally well wherever it is stays

constexpr std::int32_t kFew = 200, kSome = 800, kMany = 6000;  // samples: of all candidates, the best, the last
constexpr std::size_t kDirections = 150;                       // on half a sphere: 12 degrees apart
constexpr std::size_t kBest = 6, kLast = 2;                    // candidates that are fitted, and fitted to many
constexpr int kTurns = 15, kLastTurns = 8;                     // turns of fitting
constexpr std::int32_t kBlock = 256;                           // samples that a thread takes at a time
constexpr double kShare = 0.9;                                 // share of the surface that has to mirror
constexpr double kNoises = 4;                                  // largest mismatch in deviations of the noise
constexpr double kOfRegion = 0.06;                             // likewise as a share of sqrt(area / regions)
constexpr double kPreferred = 1.3;  // factor by which another plane has to be better than one across X, Y or Z
constexpr double kTurned = 0.94;    // cosine of the largest angle of a plane from the wanted axis: 20 degrees
constexpr double kAway = 0.05;      // share of the size: larger distances count as this one

struct Sample {
  Vec3 place, normal;
};

/// Places on the surface for equal areas, in the order of the face graph.
std::vector<Sample> samples_of(const Mesh& mesh, std::int32_t count) {
  const FaceGraph& graph = mesh.graph();
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;  // R2, a sequence of low discrepancy
  std::vector<Sample> samples;
  double total = 0, area = 0;
  for (std::int32_t i = 0; i < graph.size(); ++i) total += graph.faces[i].area;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    area += graph.faces[i].area;
    while (static_cast<std::int32_t>(samples.size()) < count &&
           (static_cast<double>(samples.size()) + 0.5) / count * total < area) {
      const auto& [a, b, c] = mesh.triangles()[graph.mesh_face[i]];
      const auto k = static_cast<double>(samples.size());
      double s = std::fmod(0.5 + k * kFirst, 1.0), t = std::fmod(0.5 + k * kSecond, 1.0);
      if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
      }
      const auto v = mesh.vertices();
      samples.push_back(
          {v[a] + s * (v[b] - v[a]) + t * (v[c] - v[a]), {graph.faces[i].nx, graph.faces[i].ny, graph.faces[i].nz}});
    }
  }
  return samples;
}

/// A plane, and its quality as a mirror of the surface.
struct Candidate {
  Mirror mirror;  // relative to the mesh's origin
  double score = 0;
  bool preferred = false;
};

/// The normal with its sign settled.
Vec3 settled(const Vec3& normal) {
  Eigen::Index at = 0;
  normal.cwiseAbs().maxCoeff(&at);
  return normal[at] < 0 ? Vec3(-normal) : normal;
}

class Finder {
 public:
  Finder(const Mesh& mesh, std::int32_t threads, Job& job)
      : job_(job), threads_(threads), size_(surface_size(mesh)), faces_(mesh, all_of(mesh)) {
    few_ = samples_of(mesh, kFew);
    some_ = samples_of(mesh, kSome);
    many_ = samples_of(mesh, kMany);
    for (const Sample& s : many_) centre_ += s.place / static_cast<double>(many_.size());
  }

  /// Whether the surface has an area, without which it has no mirror plane.
  [[nodiscard]] bool any() const { return !few_.empty() && !some_.empty() && !many_.empty(); }

  /// The best plane fitted to the candidates.
  Candidate best(std::vector<Candidate> all) {
    for (Candidate& c : all) {
      c.mirror.offset = c.mirror.normal.dot(centre_);
      score(c, few_);
    }
    shorten(all, kBest);
    for (Candidate& c : all) fit(c, some_, kTurns);
    shorten(all, kLast);
    for (Candidate& c : all) {
      fit(c, many_, kLastTurns);
      measure(c);
    }
    shorten(all, 1);
    return all.front();
  }

  [[nodiscard]] std::vector<Candidate> everywhere() const {
    std::vector<Candidate> all = across({Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()});
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const Sample& s : many_) inertia += (s.place - centre_) * (s.place - centre_).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
    std::vector<Vec3> directions;
    directions.reserve(3 + kDirections);
    for (int k = 0; k < 3; ++k) directions.emplace_back(axes.eigenvectors().col(k));
    for (std::size_t k = 0; k < kDirections; ++k) {  // along a spiral
      const double z = (static_cast<double>(k) + 0.5) / kDirections;
      const double angle = static_cast<double>(k) * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
      directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    for (Candidate& c : across(directions)) {
      c.preferred = false;
      all.push_back(c);
    }
    return all;
  }

  static std::vector<Candidate> across(const std::vector<Vec3>& directions) {
    std::vector<Candidate> all;
    all.reserve(directions.size());
    for (const Vec3& d : directions) all.push_back({{.normal = settled(d.normalized())}, 0, true});
    return all;
  }

 private:
  static std::vector<std::int32_t> all_of(const Mesh& mesh) {
    std::vector<std::int32_t> faces(static_cast<std::size_t>(mesh.face_count()));
    std::iota(faces.begin(), faces.end(), 0);
    return faces;
  }

  /// The faces that the images of samples are closest to.
  [[nodiscard]] std::vector<ClosestFace> closest(const Mirror& mirror, std::span<const Sample> samples) const {
    std::vector<ClosestFace> found(samples.size());
    threads_.blocks(static_cast<std::int32_t>(samples.size()), kBlock,
                    [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                      job_.poll();
                      double guess = 0;
                      for (std::int32_t i = begin; i < end; ++i) {
                        const Vec3 facing = mirror.turned(samples[i].normal);
                        found[i] = faces_.find(mirror.image(samples[i].place), facing, guess, kAway * size_);
                        guess = std::isinf(found[i].distance) ? 0 : found[i].distance;
                      }
                    });
    return found;
  }

  [[nodiscard]] double capped(const ClosestFace& c) const { return std::min(c.distance, kAway * size_); }

  void score(Candidate& c, std::span<const Sample> samples) const {
    c.score = 0;
    for (const ClosestFace& face : closest(c.mirror, samples)) c.score += capped(face);
  }

  /// Leaves the best, each plane once.
  void shorten(std::vector<Candidate>& all, std::size_t most) const {
    const auto rank = [](const Candidate& c) { return c.preferred ? c.score / kPreferred : c.score; };
    std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    std::vector<Candidate> kept;
    for (const Candidate& c : all) {
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& k) {
        return std::abs(k.mirror.normal.dot(c.mirror.normal)) > 0.9999 &&
               std::abs(k.mirror.height(centre_) - c.mirror.height(centre_)) < 1e-3 * size_;
      });
      if (!known && kept.size() < most) kept.push_back(c);
    }
    all = std::move(kept);
  }

  /// Turns and shifts the plane until the images of samples are nearest to the faces that they are closest to.
  void fit(Candidate& c, std::span<const Sample> samples, int turns) const {
    for (int turn = 0; turn < turns; ++turn) {
      const std::vector<ClosestFace> found = closest(c.mirror, samples);
      if (turn > 0 && !step(c, samples, found)) break;
      if (turn == 0) step(c, samples, found);
    }
    score(c, samples);
  }

  /// One step of Gauss and Newton.
  /// \return whether the plane has moved
  bool step(Candidate& c, std::span<const Sample> samples, std::span<const ClosestFace> found) const {
    Mirror& m = c.mirror;
    const Vec3 u = m.normal.unitOrthogonal(), v = m.normal.cross(u);
    std::vector<double> sorted;
    sorted.reserve(found.size());
    for (const ClosestFace& f : found) sorted.push_back(capped(f));
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double usual = std::max(2 * sorted[sorted.size() / 2], 1e-9 * size_);
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Vec3 b = Vec3::Zero();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (found[i].face == kNone) continue;
      const Vec3 x = samples[i].place - centre_, plane = faces_.normal(found[i].face);
      const double height = m.height(samples[i].place);
      const double miss = plane.dot(m.image(samples[i].place) - faces_.corners(found[i].face)[0]);
      // The growth of `miss` where the plane turns about the centroid towards u and v, and where it is shifted.
      const Vec3 grows(-2 * (u.dot(x) * plane.dot(m.normal) + height * plane.dot(u)),
                       -2 * (v.dot(x) * plane.dot(m.normal) + height * plane.dot(v)), 2 * plane.dot(m.normal));
      const double weight = 1 / (1 + (found[i].distance / usual) * (found[i].distance / usual));
      a += weight * grows * grows.transpose();
      b -= weight * miss * grows;
    }
    for (int k = 0; k < 3; ++k) a(k, k) = a(k, k) > 0 ? (1 + kDamping) * a(k, k) : 1.0;
    const Vec3 by = solve_balanced(a, b);
    if (!by.allFinite()) return false;
    const double shift = m.normal.dot(centre_);
    const double turn = std::hypot(by[0], by[1]), most = 0.2;
    const double share = turn > most ? most / turn : 1;
    const double above = m.offset - shift + share * by[2];
    m.normal = settled((m.normal + share * (by[0] * u + by[1] * v)).normalized());
    // `settled` may have reversed the normal.
    m.offset = m.normal.dot(centre_) + (m.normal.dot(u.cross(v)) < 0 ? -above : above);
    return turn > 1e-7 || std::abs(by[2]) > 1e-7 * size_;
  }

  void measure(Candidate& c) const {
    std::vector<double> distance;
    distance.reserve(many_.size());
    for (const ClosestFace& f : closest(c.mirror, many_)) distance.push_back(capped(f));
    c.mirror.mismatch_mean =
        std::accumulate(distance.begin(), distance.end(), 0.0) / static_cast<double>(distance.size());
    const auto at = distance.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(distance.size() - 1));
    std::nth_element(distance.begin(), at, distance.end());
    c.score = c.mirror.mismatch = *at;
  }

  const Job& job_;
  const Threads threads_;
  double size_;
  ClosestFaces faces_;
  std::vector<Sample> few_, some_, many_;
  Vec3 centre_ = Vec3::Zero();
};

Vec3 axis_of(Symmetry wanted) {
  return wanted == Symmetry::x ? Vec3::UnitX() : wanted == Symmetry::y ? Vec3::UnitY() : Vec3::UnitZ();
}

}  // namespace

std::optional<Mirror> find_mirror(const Mesh& mesh, Symmetry wanted, double allowed, std::int32_t threads, Job& job) {
  job.poll();
  Finder finder(mesh, threads, job);
  const bool anywhere = wanted == Symmetry::found;
  if (!finder.any()) {
    if (anywhere) return std::nullopt;
    throw InvalidInput("the surface has no area, so it has no plane in which it mirrors; choose no symmetry");
  }
  const Candidate found = finder.best(anywhere ? finder.everywhere() : Finder::across({axis_of(wanted)}));
  const bool along = anywhere || found.mirror.normal.dot(axis_of(wanted)) > kTurned;
  if (along && found.mirror.mismatch <= allowed) return found.mirror.relative_to(-mesh.origin());
  if (anywhere) return std::nullopt;
  std::ostringstream text;
  text.precision(3);
  text << "the surface does not mirror across " << (wanted == Symmetry::x ? "x" : wanted == Symmetry::y ? "y" : "z");
  if (along)
    text << ": a tenth of it is more than " << found.mirror.mismatch << " from its mirror image, and " << allowed
         << " is allowed";
  text << "; choose another axis, fewer regions or no symmetry";
  throw InvalidInput(text.str());
}

double mirror_allowance(const Mesh& mesh, const PartitionOptions& options, Job& job) {
  const double noise = options.noise ? *options.noise : estimate_noise(mesh, Threads(options.threads), job);
  const double size = options.proxies     ? kOfRegion * std::sqrt(mesh.graph().area / *options.proxies)
                      : options.tolerance ? *options.tolerance
                                          : options.detail.value_or(kDefaultDetail) * surface_size(mesh);
  return std::max(kNoises * noise, size);
}

}  // namespace isimp
