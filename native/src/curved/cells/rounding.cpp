#include "cells/rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "cells/cells.h"
#include "find/face_labels.h"
#include "fit/numbers.h"
#include "isimp/core/check.h"
#include "isimp/core/tiny.h"
#include "isimp/partition/partition.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr double kNarrow = 1;   ///< radians, the least span of one that is no full turn
constexpr double kFar = 1e300;  ///< mark: misfit of a face to a cell without a plane

/// Puts cells in the place of regions.
class Rounding {
 public:
  Rounding(const Surface& surface, const Partition& part, Scene scene)
      : surface_(surface), f_(surface), part_(part), scene_(std::move(scene)), count_(part.region_count()) {
    label_.resize(static_cast<std::size_t>(f_.size()));
    for (std::int32_t i = 0; i < f_.size(); ++i) label_[i] = part.face_region[f_.graph().mesh_face[i]];
    cell_of_.assign(label_.size(), kNone);
    before_.assign(static_cast<std::size_t>(count_), 0.0);
    middle_.assign(before_.size(), Vec3::Zero());
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (label_[i] != kNone) {
        before_[label_[i]] += f_.area(i);
        middle_[label_[i]] += f_.area(i) * f_.centre(i);
      }
    for (std::size_t r = 0; r < before_.size(); ++r) middle_[r] /= std::max(before_[r], kTiny);
  }

  Partition run(Job& job) {
    std::map<std::int32_t, std::vector<PatchCut>> cuts;  // by class
    mates_.patch.assign(label_.size(), kNone);
    for (const RoundPatch& p : scene_.patches) {
      if (p.proxy.segments > 0)
        for (const std::int32_t i : p.faces.face) mates_.patch[i] = static_cast<std::int32_t>(mates_.together.size());
      mates_.together.push_back(p.together);
    }
    for (RoundPatch& p : scene_.patches) {
      job.poll();
      if (p.proxy.segments > 0)
        if (std::optional<PatchCut> c = cut_of(p)) cuts[p.together].push_back(std::move(*c));
    }
    for (const auto& [together, some] : cuts) {
      job.poll();
      if (pay(some))
        for (const PatchCut& c : some) add(c);
    }
    if (proxies_.empty()) return part_;
    clean(job);
    return made(job);
  }

 private:
  /// A patch in cells, and faces that get the region of a plane.
  struct PatchCut {
    RoundPatch* patch = nullptr;
    Cells cells;
    std::vector<std::pair<std::int32_t, std::int32_t>> given;
  };

  std::optional<PatchCut> cut_of(RoundPatch& patch) {
    const bool is_wide = patch.proxy.full || patch.proxy.closed || patch.proxy.span >= kNarrow;
    if (!is_edit() && !is_wide) return std::nullopt;
    PatchCut c{&patch, {}, give_to_tangents(patch)};
    if (patch.faces.face.empty()) return std::nullopt;
    c.cells = cut(f_, patch.proxy, patch.faces, mates_);
    return c;
  }

  void add(const PatchCut& c) {
    const PatchFaces& faces = c.patch->faces;
    for (const auto& [face, plane] : c.given) label_[face] = region_of(plane);
    for (std::size_t k = 0; k < faces.face.size(); ++k) {
      label_[faces.face[k]] = count_ + static_cast<std::int32_t>(proxies_.size());
      cell_of_[faces.face[k]] = first_ + c.cells.of_face[k];
    }
    first_of_.push_back(first_);
    const auto count = static_cast<std::int32_t>(c.cells.cell.size());
    first_ += count;
    ideal_.insert(ideal_.end(), c.cells.cell.size(), faces.whole / count);
    cell_.insert(cell_.end(), c.cells.cell.begin(), c.cells.cell.end());
    for (auto cell = cell_.end() - count; cell != cell_.end(); ++cell)
      cell->proxy = static_cast<std::int32_t>(proxies_.size());
    normal_.insert(normal_.end(), c.cells.normal.begin(), c.cells.normal.end());
    offset_.insert(offset_.end(), c.cells.offset.begin(), c.cells.offset.end());
    proxies_.push_back(c.patch->proxy);
  }

  /// An edit of the user has no surfaces that were found.
  [[nodiscard]] bool is_edit() const { return scene_.found.empty(); }

  /// Whether the cells of patches with the same segments are about as near to the faces as the regions that were there.
  /// These may be nearer by the distance of the faces from the surface, which no cells follow, unless they are the sides
  /// of a prism. Each cell and each region has a price: the square of the nearness times the area of a region. A patch
  /// that was found must pass, an edit need not.
  [[nodiscard]] bool pay(const std::vector<PatchCut>& cuts) const {
    if (is_edit()) return true;
    double now = 0, before = 0, rough = 0, price = 0;  // price: of the regions
    const auto add = [&](std::int32_t i, const Vec3& normal, double offset) {
      now += f_.area(i) * std::pow(normal.dot(f_.centre(i)) - offset, 2);
    };
    for (const PatchCut& c : cuts) {
      before += c.patch->before;
      const double area = c.patch->faces.whole;
      rough += area * c.patch->faces.rough * c.patch->faces.rough;
      const double regions = area * scene_.near.distance * scene_.near.distance;
      price += regions;
      now += regions * static_cast<double>(c.cells.cell.size()) / c.patch->cells;
      const Some& face = c.patch->faces.face;
      for (std::size_t k = 0; k < face.size(); ++k)
        add(face[k], c.cells.normal[c.cells.of_face[k]], c.cells.offset[c.cells.of_face[k]]);
      for (const auto& [i, plane] : c.given) {
        const CurvedSurface& s = scene_.found[plane].surface;
        add(i, s.axis, s.axis.dot(s.point));
      }
    }
    return now <= kNearlyAsWell * kNearlyAsWell * (price + (before < kSpeck * rough ? before : before + rough));
  }

  /// Removes the first and the last half segment from a patch if planes touch it there.
  /// \return faces and the planes that get them
  std::vector<std::pair<std::int32_t, std::int32_t>> give_to_tangents(RoundPatch& patch) {
    std::vector<std::pair<std::int32_t, std::int32_t>> given;
    CurvedProxy& p = patch.proxy;
    const double halves = 0.5 * ((patch.tangent[0] != kNone) + (patch.tangent[1] != kNone));
    if (halves == 0) return given;
    const double width = p.span / (p.segments + halves), begin = p.phase, end = p.phase + p.span;
    Some left;
    for (std::size_t k = 0; k < patch.faces.face.size(); ++k) {
      const double middle = begin + p.span / 2, at = middle + turned(patch.faces.angle[k] - middle);
      const bool is_first = patch.tangent[0] != kNone && at < begin + width / 2;
      const bool is_last = patch.tangent[1] != kNone && at > end - width / 2;
      const std::int32_t plane = is_first || is_last ? patch.tangent[is_first ? 0 : 1] : kNone;
      if (plane == kNone || region_of(plane) == kNone)
        left.push_back(patch.faces.face[k]);
      else
        given.emplace_back(patch.faces.face[k], plane);
    }
    if (patch.tangent[0] != kNone) p.phase += width / 2;
    p.span = width * p.segments;
    patch.faces = PatchFaces(f_, p, std::move(left));
    return given;
  }

  /// The region with most of a plane's area.
  std::int32_t region_of(std::int32_t plane) {
    const auto [at, is_new] = region_of_.try_emplace(plane, kNone);
    if (!is_new) return at->second;
    std::map<std::int32_t, double> area;
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (scene_.label[i] == plane) area[part_.face_region[f_.graph().mesh_face[i]]] += f_.area(i);
    double most = 0;
    for (const auto& [region, a] : area) {
      if (region == kNone || a <= most) continue;
      most = a;
      at->second = region;
    }
    return at->second;
  }

  void clean(Job& job) {
    give_rests_away(job);
    absorb_fragments(
        f_, label_, [&](std::int32_t label) { return label < count_ ? 0.0 : kQuarter * ideal_[label - count_]; },
        nullptr, [&](std::int32_t label) { return takes(label); }, job);
  }

  /// Whether a label may get faces of others: locked regions stay as they are, and no face leaves the regions.
  [[nodiscard]] bool takes(std::int32_t label) const {
    return label >= count_ || (label != kNone && (part_.region_locked.empty() || part_.region_locked[label] == 0));
  }

  /// Adds small rests of regions to the neighbours that they fit, which are regions or whole patches. Then the faces of
  /// patches get their cells.
  void give_rests_away(Job& job) {
    std::vector<double> now(before_.size(), 0.0);
    double all = 0;
    for (std::int32_t i = 0; i < f_.size(); ++i) {
      all += f_.area(i);
      if (label_[i] >= 0 && label_[i] < count_) now[label_[i]] += f_.area(i);
    }
    const double least = kSpeck * all / (count_ + first_);
    const std::vector<CellGrid> grid(proxies_.begin(), proxies_.end());
    const auto cell_at = [&](std::int32_t patch, std::int32_t i) {
      const std::int32_t cell = first_of_[patch] + grid[patch].at(f_.centre(i));
      return normal_[cell].isZero() ? kNone : cell;  // a part of the profile without faces has no plane
    };
    absorb_fragments(
        f_, label_,
        [&](std::int32_t label) {
          if (label == kNone || label >= count_) return 0.0;
          const bool is_same = now[label] >= before_[label] * (1 - 1e-9);
          if (is_same) return 0.0;
          return now[label] < kQuarter * before_[label] ? std::numeric_limits<double>::infinity() : least;
        },
        [&](std::int32_t i, std::int32_t label) {
          const std::int32_t cell = label >= count_ ? cell_at(label - count_, i) : kNone;
          if (label >= count_ && cell == kNone) return kFar;
          const Vec3 x = f_.centre(i);
          const double away =
              cell == kNone ? part_.region_normal[label].dot(x - middle_[label]) : normal_[cell].dot(x) - offset_[cell];
          return f_.area(i) * away * away;
        },
        [&](std::int32_t label) { return takes(label); }, job);
    // A rest that joined one cell as a whole could cut its neighbours off from the rim.
    for (std::int32_t i = 0; i < f_.size(); ++i) {
      const std::int32_t patch = label_[i] - count_;
      if (patch < 0) continue;
      const std::int32_t cell = cell_of_[i] == kNone ? cell_at(patch, i) : cell_of_[i];
      label_[i] = cell == kNone ? part_.face_region[f_.graph().mesh_face[i]] : count_ + cell;
    }
  }

  [[nodiscard]] Partition made(Job& job) const {
    Some by_face(label_.size());
    for (std::int32_t i = 0; i < f_.size(); ++i) by_face[f_.graph().mesh_face[i]] = label_[i];
    Partition out = inherited(partition_from(surface_, by_face, job), part_);
    out.bound = out.distance_max = 0;  // as after an edit
    out.proxies_asked = part_.proxies_asked;
    const auto regions = static_cast<std::size_t>(out.region_count());
    out.region_offset.resize(regions, 0.0);
    out.region_held.resize(regions, 0);
    out.region_cell.resize(regions);
    const auto before = static_cast<std::int32_t>(out.curved.size());  // patches of locked regions
    out.curved.insert(out.curved.end(), proxies_.begin(), proxies_.end());
    for (std::size_t p = 0; p < proxies_.size(); ++p) out.curved[before + p].point += f_.mesh().origin();
    for (std::size_t r = 0; r < regions; ++r) {
      const std::int32_t label = by_face[out.region_seed[r]], c = label - count_;
      if (c < 0) {
        if (out.region_sum[r].faces != part_.region_sum[label].faces && out.region_held[r] != 0) {
          out.region_held[r] = 0;
          out.region_cell[r] = {};
          out.region_normal[r] = out.region_sum[r].normal();
        }
        continue;
      }
      out.region_cell[r] = cell_[c];
      out.region_cell[r].proxy += before;
      out.region_held[r] = kPlaneRound;
      out.region_normal[r] = normal_[c];
      out.region_offset[r] = offset_[c] + normal_[c].dot(f_.mesh().origin());
    }
    place_free_planes(f_.mesh(), out);
    return out;
  }

  const Surface& surface_;
  Faces f_;
  const Partition& part_;
  Scene scene_;
  std::int32_t count_, first_ = 0;  // number of regions of the partition; number of added cells
  Mates mates_;
  Some label_;                  // (n) by graph index: a region, or count_ + a patch, at the end count_ + a cell
  Some cell_of_;                // (n) by graph index: the cell of a face of a patch
  std::vector<double> before_;  // area of each region
  std::vector<Vec3> middle_;    // ... and its centre
  std::vector<CurvedProxy> proxies_;
  Some first_of_;  // by patch: its first cell
  std::vector<CurvedCell> cell_;
  std::vector<Vec3> normal_;
  std::vector<double> offset_, ideal_;
  std::map<std::int32_t, std::int32_t> region_of_;
};

/// Drops the patches without a cell.
void drop_empty(Partition& part) {
  std::vector<std::int32_t> number(part.curved.size(), kNone);
  for (const CurvedCell& c : part.region_cell)
    if (c.proxy != kNone) number[c.proxy] = 0;
  std::vector<CurvedProxy> left;
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] == kNone) continue;
    number[p] = static_cast<std::int32_t>(left.size());
    left.push_back(std::move(part.curved[p]));
  }
  part.curved = std::move(left);
  for (CurvedCell& c : part.region_cell)
    if (c.proxy != kNone) c.proxy = number[c.proxy];
}

}  // namespace

Partition with_cells(const Surface& surface, const Partition& part, Scene scene, Job& job) {
  Partition out = Rounding(surface, part, std::move(scene)).run(job);
  drop_empty(out);
  ISIMP_ASSERT(
      std::ranges::all_of(out.region_cell, [&](const CurvedCell& c) { return c.proxy < std::ssize(out.curved); }),
      "cells are of patches that are there");
  return out;
}

}  // namespace isimp::curved
