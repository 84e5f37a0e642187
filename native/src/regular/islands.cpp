#include "islands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "isimp/core/sorted.h"
#include "isimp/partition/keep_regions.h"
#include "isimp/partition/surface.h"

namespace isimp::regular {
namespace {

/// The regions of a partition, with their adjacency.
class Islands {
 public:
  Islands(const Mesh& mesh, const Partition& partition, std::span<const double> area, double depth)
      : mesh_(mesh),
        part_(partition),
        depth_(depth),
        area_(area.begin(), area.end()),
        beside_(area.size()),
        faces_(area.size()),
        into_(area.size()),
        seen_(area.size(), kNone) {
    std::iota(into_.begin(), into_.end(), 0);
    const auto& region = part_.face_region;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const std::int32_t r = region[f];
      if (r == kNone) continue;
      faces_[r].push_back(f);
      for (std::int32_t k = 0; k < 3; ++k) {
        const std::int32_t h = mesh.opposite(3 * f + k), other = h == kNone ? kNone : region[h / 3];
        if (other != r) beside_[r].push_back(other);
      }
    }
    for (auto& some : beside_) sort_unique(some);
    for (const auto& [f, g] : separated_faces(Surface(mesh, part_.guided))) {
      barred_.insert({region[f], region[g]});
      barred_.insert({region[g], region[f]});
    }
  }

  std::vector<std::int32_t> find(const Job& job) {
    std::vector<std::int32_t> order = into_;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return area_[a] > area_[b]; });
    for (const std::int32_t wall : order) {
      if (!part_.is_held(wall) || is_locked(wall)) continue;
      job.poll();
      for (const std::int32_t island : order) {
        if (into_[wall] != wall) break;
        if (into_[island] != island || island == wall || !part_.is_held(island) || !is_one_plane(wall, island))
          continue;
        for (const std::int32_t r : surrounded(wall, island)) {
          into_[r] = wall;
          area_[wall] += area_[r];
        }
      }
    }
    return into_;
  }

 private:
  [[nodiscard]] bool is_locked(std::int32_t r) const {
    return !part_.region_locked.empty() && part_.region_locked[r] != 0;
  }
  [[nodiscard]] bool is_one_plane(std::int32_t a, std::int32_t b) const {
    return (part_.region_normal[a] - part_.region_normal[b]).norm() <= kSame &&
           std::abs(part_.region_offset[a] - part_.region_offset[b]) <= kSame * mesh_.diagonal();
  }
  /// Whether a region may become part of a wall.
  [[nodiscard]] bool may(std::int32_t wall, std::int32_t r) const {
    if (is_locked(r)) return false;
    const bool by_person = part_.region_held[r] != 0 && part_.region_held[r] != kPlaneSnapped;
    if (by_person && !is_one_plane(wall, r)) return false;
    const double offset = part_.offset_from(mesh_.origin(), wall);
    return std::all_of(faces_[r].begin(), faces_[r].end(), [&](std::int32_t f) {
      const Triangle& t = mesh_.triangles()[f];
      return std::all_of(t.begin(), t.end(), [&](std::int32_t v) {
        return std::abs(part_.region_normal[wall].dot(mesh_.vertices()[v]) - offset) <= depth_;
      });
    });
  }

  /// An island and its rim; empty if they are not surrounded by the wall alone. Regions that are already part of the
  /// wall count as it.
  std::vector<std::int32_t> surrounded(std::int32_t wall, std::int32_t island) {
    const std::int32_t stamp = stamps_++;
    std::vector<std::int32_t> found{island};
    seen_[island] = stamp;
    double area = 0;
    bool met = false;  // else the island is a component of its own
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::int32_t r = found[i];
      area += area_[r];
      if (area >= area_[wall] || !may(wall, r)) return {};
      for (const std::int32_t other : beside_[r]) {
        if (other == kNone || barred_.contains({r, other})) return {};
        met = met || into_[other] == wall;
        if (into_[other] == wall || seen_[other] == stamp) continue;
        if (into_[other] != other) return {};
        seen_[other] = stamp;
        found.push_back(other);
      }
    }
    if (!met) found.clear();
    return found;
  }

  const Mesh& mesh_;
  const Partition& part_;
  const double depth_;
  std::vector<double> area_;  // by region, updated as they grow
  std::vector<std::vector<std::int32_t>>
      beside_;  // by region: its neighbours; kNone for a border or a part that was left out
  std::vector<std::vector<std::int32_t>> faces_;  // by region
  std::set<std::array<std::int32_t, 2>> barred_;  // pairs of regions with a barrier between them
  std::vector<std::int32_t> into_, seen_;         // by region; seen_: the search that visited it
  std::int32_t stamps_ = 0;
};

/// \param into  by region: the region that it becomes part of, itself if it stays
/// \return the regions that stay
std::vector<std::int32_t> unite_regions(const Mesh& mesh, Partition& p, std::span<const std::int32_t> into) {
  std::vector<std::int32_t> stays, number(into.size(), kNone);
  for (std::int32_t r = 0; r < static_cast<std::int32_t>(into.size()); ++r) {
    if (into[r] != r) {
      p.region_sum[into[r]].add(p.region_sum[r]);
    } else {
      number[r] = static_cast<std::int32_t>(stays.size());
      stays.push_back(r);
    }
  }
  if (stays.size() == into.size()) return stays;
  for (std::int32_t& r : p.face_region)
    if (r != kNone) r = number[into[r]];
  keep_regions(p, stays);
  p.error = 0;
  const double area = Surface(mesh, p.guided).graph().area;
  for (const RegionSum& s : p.region_sum) p.error += s.error() * area;
  p.history.assign(1, p.error);
  if (p.symmetry) p.symmetry->regions = kNone;
  return stays;
}

}  // namespace

std::vector<std::int32_t> merge_islands(const Mesh& mesh, Partition& partition, std::span<RegionPlane* const> regions,
                                        double depth, const Job& job) {
  std::vector<double> area;
  for (const RegionPlane* r : regions) area.push_back(r->scan.area);
  const std::vector<std::int32_t> into = Islands(mesh, partition, area, depth).find(job);
  for (std::size_t i = 0; i < into.size(); ++i) {
    if (into[i] == static_cast<std::int32_t>(i)) continue;
    RegionPlane& wall = *regions[into[i]];
    if (regions[i]->scan.projected > 0) wall.scan = meshing::united(wall.scan, regions[i]->scan);
    wall.faces += regions[i]->faces;
  }
  return unite_regions(mesh, partition, into);
}

}  // namespace isimp::regular
