#include "symmetric.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "borders/local.h"
#include "borders/relax.h"
#include "closest_faces.h"
#include "components.h"
#include "density/noise.h"
#include "isimp/core/check.h"
#include "isimp/core/threads.h"
#include "isimp/core/to_integer.h"
#include "isimp/simplify/mirror.h"
#include "make_partition.h"

namespace isimp {
namespace {

constexpr int kTries = 5;              // numbers of regions tried for the half
constexpr int kSweeps = 60;            // sweeps of the borders of the whole
constexpr std::int32_t kBlock = 1024;  // faces that a thread takes at a time
constexpr double kFar = 0.25;          // share of sqrt(area / regions): a face that is farther from its image has none
constexpr double kOwnRegion = 0.5;     // share of area / regions: smaller pieces without an image join their neighbours
constexpr double kWorth = 1.0;         // cost of a join at the plane, as a share of the mean error of a region
constexpr double kPart = 0.25;         // share of the largest piece of a region: smaller pieces join their neighbours
constexpr std::int32_t kApart = -3;    // the label of faces whose pieces are sought

class Symmetriser {
 public:
  Symmetriser(const Partitioner& partitioner, const Surface& surface, const PartitionOptions& options,
              const Constraints& constraints, const Mirror& mirror, Job& job)
      : partitioner_(partitioner),
        surface_(surface),
        mesh_(surface.mesh()),
        graph_(surface.graph()),
        options_(options),
        constraints_(constraints),
        mirror_(mirror.relative_to(mesh_.origin())),
        threads_(options.threads),
        job_(job) {}

  Partition run() {
    {
      const Job::Stage stage(job_, "halving", 0.0, 0.2);
      choose_sides();
      find_images();
    }
    {
      const Job::Stage stage(job_, "partitioning", 0.2, 0.8);
      split_apart();
      choose_number();
    }
    const Job::Stage stage(job_, "mirroring", 0.8, 1.0);
    carry_over();
    mend();
    relax();
    fold_back();
    carry_over();
    mend();
    Partition result = finished();
    result.symmetry->regions = mirrored_regions(mesh_, result, *result.symmetry);
    return result;
  }

 private:
  [[nodiscard]] Vec3 middle(std::int32_t f) const {
    const auto& [a, b, c] = mesh_.triangles()[f];
    return (mesh_.vertices()[a] + mesh_.vertices()[b] + mesh_.vertices()[c]) / 3;
  }
  [[nodiscard]] double area(std::int32_t f) const { return graph_.faces[graph_.graph_face[f]].area; }
  [[nodiscard]] Vec3 normal(std::int32_t f) const {
    const FaceRecord& r = graph_.faces[graph_.graph_face[f]];
    return {r.nx, r.ny, r.nz};
  }
  [[nodiscard]] std::int32_t wanted() const { return options_.proxies.value_or(0); }

  /// The half with more of the surface is split; the other one follows it.
  void choose_sides() {
    const Components components = find_components(mesh_, options_.proxies.value_or(1), options_.leave_out, job_);
    std::array<double, 2> areas{};
    std::array<std::vector<std::int32_t>, 2> sides;
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
      if (!components.all[mesh_.component()[f]].kept) continue;
      const int side = mirror_.height(middle(f)) < 0 ? 1 : 0;
      sides[side].push_back(f);
      areas[side] += area(f);
    }
    area_ = areas[0] + areas[1];
    const int larger = areas[1] > areas[0] || sides[0].empty() ? 1 : 0;
    half_ = std::move(sides[larger]);
    other_ = std::move(sides[1 - larger]);
    is_half_.assign(static_cast<std::size_t>(mesh_.face_count()), 0);
    for (const std::int32_t f : half_) is_half_[f] = 1;
    label_.assign(static_cast<std::size_t>(mesh_.face_count()), kNone);
    for (const std::int32_t f : half_) label_[f] = kApart;
    for (const std::int32_t f : half_) {
      if (label_[f] != kApart) continue;
      (void)take_out(graph_, labels(), graph_.graph_face[f]);
      ++half_pieces_;
    }
  }

  /// The faces of the half that are closest to the images of the others.
  void find_images() {
    const ClosestFaces faces(mesh_, half_);
    const double width = std::sqrt(mesh_.graph().area / std::max(wanted(), kFewest));
    const double most = std::max(kFar * width, 2 * mirror_.mismatch);
    image_.assign(other_.size(), kNone);
    threads_.blocks(static_cast<std::int32_t>(other_.size()), kBlock,
                    [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                      double guess = 0;
                      for (std::int32_t i = begin; i < end; ++i) {
                        if (i % 64 == 0) job_.poll();
                        const Vec3 place = mirror_.image(middle(other_[i])), facing = mirror_.turned(normal(other_[i]));
                        const ClosestFace found = faces.find(place, facing, guess, most);
                        image_[i] = found.face;
                        guess = found.face == kNone ? 0 : found.distance;
                      }
                    });
  }

  /// Splits the parts of the other half that have no image, where they are large enough for regions of their own.
  void split_apart() {
    for (std::size_t i = 0; i < other_.size(); ++i)
      if (image_[i] == kNone) label_[other_[i]] = kApart;
    std::vector<std::int32_t> large;
    double size = 0;
    const double least = kOwnRegion * area_ / std::max(wanted(), kFewest);
    for (const std::int32_t start : other_) {
      if (label_[start] != kApart) continue;
      const std::vector<std::int32_t> patch = take_out(graph_, labels(), graph_.graph_face[start]);
      double sum = 0;
      for (const std::int32_t i : patch) sum += graph_.faces[i].area;
      if (sum < least) continue;
      size += sum;
      ++apart_pieces_;
      for (const std::int32_t i : patch) large.push_back(graph_.mesh_face[i]);
    }
    for (const std::int32_t f : other_) label_[f] = kNone;
    apart_.assign(label_.size(), kNone);
    if (large.empty()) return;
    std::sort(large.begin(), large.end());
    PartitionOptions options = options_;
    if (options.proxies) options.proxies = to_integer(std::round(size / area_ * wanted()), 1, mesh_.face_count());
    const Partition split = run_on(large, options);
    for (const std::int32_t f : large) apart_[f] = split.face_region[f];
    apart_count_ = split.region_count();
  }

  [[nodiscard]] Partition run_on(const std::vector<std::int32_t>& faces, PartitionOptions options) const {
    options.metric = Metric::normals;  // by distances, borders go on after mirroring and are no longer alike
    const Constraints constraints{.guides = constraints_.guides, .cuts = constraints_.cuts, .faces = faces};
    return partitioner_.run(options, constraints, job_);
  }

  /// Splits the half into the number of regions that gives the wanted number, with their images and joins.
  void choose_number() {
    PartitionOptions options = options_;
    if (!options_.proxies) {
      if (options.detail || !options.tolerance)
        options.tolerance = options.detail.value_or(kDefaultDetail) * surface_size(mesh_);
      options.detail.reset();
      take_half(run_on(half_, options));
      return;
    }
    const std::int32_t wanted_here = std::max(1, wanted() - apart_count_);
    const auto most = static_cast<std::int32_t>(half_.size());
    const std::int32_t fewest = std::clamp((wanted_here + 1) / 2, 1, most);
    std::int32_t span = 0;  // regions that the half may have in addition if all possible joins are made
    std::optional<Partition> best;
    double least = 0;
    for (int k = 0; k < kTries; ++k) {
      const Job::Stage stage(job_, "partitioning", static_cast<double>(k) / kTries, (k + 1.0) / kTries);
      options.proxies = std::min(most, fewest + span * k / (kTries - 1));
      const bool is_new = k == 0 || *options.proxies != fewest + span * (k - 1) / (kTries - 1);
      if (!is_new) continue;
      Partition half = run_on(half_, options);
      take_half(half);
      settle_joins(wanted_here);
      if (k == 0)
        span = static_cast<std::int32_t>(
                   std::count_if(cost_.begin(), cost_.end(), [](const auto& c) { return c.has_value(); })) /
                   2 +
               1;
      const std::int32_t missing = std::abs(wanted_here - (2 * regions_ - joined_count()));
      const double price = price_ + missing;  // errors are below 4
      if (best && price >= least) continue;
      least = price;
      best = std::move(half);
    }
    take_half(*best);
    settle_joins(wanted_here);
  }

  void take_half(const Partition& half) {
    how_ = half;
    regions_ = half.region_count();
    for (const std::int32_t f : half_) label_[f] = half.face_region[f];
    find_joins();
  }

  /// The cost of joining each region with its image, and the joins that are worth it.
  void find_joins() {
    std::vector<RegionSum> sums(static_cast<std::size_t>(regions_));
    std::vector<double> between(sums.size(), 0.0);  // length of the border at the plane, scene units
    std::vector<std::int32_t> image(label_.size(), kNone);
    for (std::size_t i = 0; i < other_.size(); ++i)
      if (image_[i] != kNone) image[other_[i]] = label_[image_[i]];
    for (const std::int32_t f : half_) {
      const std::int32_t r = label_[f];
      ISIMP_ASSERT(r >= 0 && r < regions_, "every face of the half is in a region");
      sums[r].add(graph_.faces[graph_.graph_face[f]]);
      const auto& beside = graph_.neighbours[graph_.graph_face[f]];
      for (const std::int32_t j : beside) {
        if (j == graph_.size()) continue;
        const std::int32_t g = graph_.mesh_face[j];
        if (is_half_[g] == 0 && image[g] == r) between[r] += shared_length(f, g);
      }
    }
    error_ = 0;
    for (const RegionSum& s : sums) error_ += 2 * s.error();
    const double count = std::max(1, 2 * regions_), width = std::sqrt(mesh_.graph().area / count);
    const double price = border_price(error_, options_.smooth) * width / mesh_.graph().area;
    cost_.assign(sums.size(), std::nullopt);
    joined_.assign(sums.size(), 0);
    for (std::size_t r = 0; r < sums.size(); ++r) {
      if (!(between[r] > 0)) continue;
      const Vec3 s(sums[r].x, sums[r].y, sums[r].z);
      const Vec3 flat = s - mirror_.normal.dot(s) * mirror_.normal;
      cost_[r] = 4 * (s.norm() - flat.norm()) - price * between[r];
      joined_[r] = *cost_[r] <= kWorth * error_ / count + kRounding ? 1 : 0;
    }
  }

  /// Length of the edges that two faces share.
  [[nodiscard]] double shared_length(std::int32_t f, std::int32_t g) const {
    double length = 0;
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      const std::int32_t o = mesh_.opposite(h);
      if (o != kNone && Mesh::face(o) == g)
        length += (mesh_.vertices()[mesh_.to(h)] - mesh_.vertices()[mesh_.from(h)]).norm();
    }
    return length;
  }

  [[nodiscard]] std::int32_t joined_count() const {
    return static_cast<std::int32_t>(std::count(joined_.begin(), joined_.end(), 1));
  }

  /// Joins as many, cheapest first, that there are as many regions as wanted.
  void settle_joins(std::int32_t wanted_here) {
    std::vector<std::int32_t> order;
    for (std::int32_t r = 0; r < regions_; ++r)
      if (cost_[r]) order.push_back(r);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return *cost_[a] < *cost_[b]; });
    const auto candidates = static_cast<std::int32_t>(order.size());
    const std::int32_t joins = std::clamp(2 * regions_ - wanted_here, 0, candidates);
    price_ = error_;
    for (std::int32_t k = 0; k < candidates; ++k) {
      joined_[order[k]] = k < joins ? 1 : 0;
      if (k < joins) price_ += *cost_[order[k]];
    }
  }

  /// All labels: the regions of the half, their images, the regions apart, and one for faces that nothing reaches.
  [[nodiscard]] std::size_t label_count() const { return static_cast<std::size_t>(2 * regions_ + apart_count_) + 1; }
  [[nodiscard]] MeshLabels labels() { return {label_.data(), &graph_}; }
  /// The label of the image of a region of the half, or of one that has come across the plane; kOpen without an image.
  [[nodiscard]] std::int32_t image_of(std::int32_t region) const {
    if (region < 0 || region >= 2 * regions_) return kOpen;
    if (region >= regions_) return region - regions_;
    return joined_[region] != 0 ? region : region + regions_;
  }

  /// Copies the labels of the half to the other half. Its regions that are not joined have the numbers from `regions_`
  /// on, and the regions apart have the numbers after these.
  void carry_over() {
    for (std::size_t i = 0; i < other_.size(); ++i) {
      const std::int32_t f = other_[i], g = image_[i];
      label_[f] = apart_[f] != kNone ? 2 * regions_ + apart_[f] : g == kNone ? kOpen : image_of(label_[g]);
    }
  }

  /// Opens the pieces of each region that are much smaller than its largest one, and adds open faces to the regions
  /// around.
  void mend() {
    struct ConnectedFaces {
      std::int32_t region, first;
      double area;
    };
    std::vector<ConnectedFaces> pieces;
    std::vector<double> largest(label_count(), -1.0);
    std::vector<std::uint8_t> seen(label_.size(), 0);
    const auto walk = [&](std::int32_t start, auto visit) {
      std::vector<std::int32_t> ahead{start};
      seen[start] ^= 1;
      for (std::size_t k = 0; k < ahead.size(); ++k) {
        visit(ahead[k]);
        for (const std::int32_t j : graph_.neighbours[graph_.graph_face[ahead[k]]]) {
          if (j == graph_.size()) continue;
          const std::int32_t g = graph_.mesh_face[j];
          if (seen[g] != seen[start] && label_[g] == label_[start]) {
            seen[g] ^= 1;
            ahead.push_back(g);
          }
        }
      }
      return ahead;
    };
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
      if (label_[f] < 0 || seen[f] != 0) continue;
      double sum = 0;
      (void)walk(f, [&](std::int32_t g) { sum += area(g); });
      pieces.push_back({label_[f], f, sum});
      largest[label_[f]] = std::max(largest[label_[f]], sum);
    }
    for (const ConnectedFaces& p : pieces) {
      const bool across = p.region < regions_ && joined_[p.region] != 0;
      if (p.area < (across ? kPart : 1.0) * largest[p.region])
        for (const std::int32_t g : walk(p.first, [](std::int32_t) {})) label_[g] = kOpen;
    }
    fill_open();
  }

  void fill_open() {
    sum_up();
    std::vector<std::int32_t> open, touched;
    for (std::int32_t i = 0; i < graph_.size(); ++i)
      if (labels().get(i) == kOpen) open.push_back(i);
    if (!open.empty()) (void)flood_from_around(graph_, labels(), open, sums_, touched);
    // A part of the surface that nothing reaches is one region.
    for (const std::int32_t i : open)
      if (labels().get(i) == kOpen) labels().set(i, static_cast<std::int32_t>(sums_.size()) - 1);
  }

  /// The sums of all regions, and an empty one.
  void sum_up() {
    sums_.assign(label_count(), {});
    for (std::int32_t i = 0; i < graph_.size(); ++i)
      if (const std::int32_t r = labels().get(i); r >= 0) {
        ISIMP_ASSERT(static_cast<std::size_t>(r) < sums_.size(), "labels are below label_count()");
        sums_[r].add(graph_.faces[i]);
      }
  }

  void relax() {
    sum_up();
    double error = 0;
    for (const RegionSum& s : sums_) error += s.error();
    const std::int64_t regions = 2 * regions_ - joined_count() + apart_count_;
    Relaxation<MeshLabels> relaxation(graph_, labels(), sums_,
                                      border_weight(error, how_.smooth, graph_.size(), regions), threads_,
                                      surface_.relative_weight());
    for (std::int32_t i = 0; i < graph_.size(); ++i)
      if (labels().get(i) >= 0) relaxation.push_if_border(i);
    relaxation.run(kSweeps, job_);
  }

  /// Restores the half's own numbers where regions of the other half have come across the plane.
  void fold_back() {
    for (const std::int32_t f : half_) {
      std::int32_t& r = label_[f];
      if (r >= 2 * regions_)
        r = kOpen;
      else if (r >= regions_)
        r -= regions_;
    }
    fill_open();
  }

  [[nodiscard]] Partition finished() {
    Partition result = partition_from(surface_, label_, job_);
    take_how_found(result, how_);
    if (options_.proxies) result.proxies_asked = *options_.proxies;
    const Components components = find_components(surface_, options_.proxies.value_or(1), options_.leave_out, job_);
    // Each piece that the plane makes of a component needs a region, and so does its image unless both are joined. So
    // does a component that no region reaches (fill_open).
    const auto unreached = std::count_if(result.region_seed.begin(), result.region_seed.end(),
                                         [&](auto f) { return label_[f] == 2 * regions_ + apart_count_; });
    result.proxies_needed = std::max(
        components.needed, 2 * half_pieces_ - joined_count() + apart_pieces_ + static_cast<std::int32_t>(unreached));
    result.parts_left_out = components.left_out;
    result.area_left_out = components.area_left_out;
    result.symmetry = mirror_.relative_to(-mesh_.origin());
    return result;
  }

  static constexpr std::int32_t kFewest = 20;  // regions by which sizes are judged where their number is not known
  static constexpr double kRounding = 1e-7;    // share of the area: smaller errors are none

  const Partitioner& partitioner_;
  const Surface& surface_;
  const Mesh& mesh_;
  const FaceGraph& graph_;
  const PartitionOptions& options_;
  const Constraints& constraints_;
  const Mirror mirror_;  // relative to the mesh's origin
  const Threads threads_;
  Job& job_;

  std::vector<std::int32_t> half_, other_;           // faces
  std::vector<std::uint8_t> is_half_;                // (F)
  std::vector<std::int32_t> image_;                  // a face of the half, for each of `other_`
  std::vector<std::int32_t> label_;                  // (F)
  std::vector<std::int32_t> apart_;                  // (F) region of the faces without an image
  std::int32_t regions_ = 0, apart_count_ = 0;       // number of regions of the half, and of regions without an image
  std::int32_t half_pieces_ = 0, apart_pieces_ = 0;  // connected pieces of both
  double area_ = 0;                                  // area of both halves, as a share
  Partition how_;                                    // partition of the half
  std::vector<std::optional<double>> cost_;          // cost of joining each region of the half with its image
  double error_ = 0, price_ = 0;                     // error of the half and its image; the same with the cost of joins
  std::vector<std::uint8_t> joined_;                 // by region of the half
  std::vector<RegionSum> sums_;                      // sums of all regions
};

}  // namespace

std::int32_t mirrored_regions(const Mesh& mesh, const Partition& partition, const Mirror& mirror) {
  std::vector<Patch> patches(static_cast<std::size_t>(partition.region_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (partition.face_region[f] == kNone) continue;
    Patch& p = patches[partition.face_region[f]];
    const auto& [a, b, c] = mesh.triangles()[f];
    const auto v = mesh.vertices();
    const double area = (v[b] - v[a]).cross(v[c] - v[a]).norm() / 2;
    p.area += area;
    p.centre += area / 3 * (v[a] + v[b] + v[c]);
    p.normal += (v[b] - v[a]).cross(v[c] - v[a]) / 2;
  }
  for (Patch& p : patches) {
    if (p.area > 0) p.centre /= p.area;
    p.normal.normalize();
  }
  const std::vector<std::int32_t> image = mirror_images(patches, mirror.relative_to(mesh.origin()));
  return static_cast<std::int32_t>(std::count_if(image.begin(), image.end(), [](auto i) { return i != kNone; }));
}

Partition symmetric_partition(const Partitioner& partitioner, const Surface& surface, const PartitionOptions& options,
                              const Constraints& constraints, const Mirror& mirror, Job& job) {
  return Symmetriser(partitioner, surface, options, constraints, mirror, job).run();
}

}  // namespace isimp
