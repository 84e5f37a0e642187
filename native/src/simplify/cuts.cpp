// Splits regions along edges that end inside them.
#include <algorithm>
#include <utility>

#include "isimp/mesh/find_edge.h"
#include "isimp/simplify/constraints.h"

namespace isimp {
namespace {

/// An edge between two faces by its ends, the lower first, and the lower of its half-edges.
struct MarkedEdge {
  VertexPair ends;
  std::int32_t halfedge;
  auto operator<=>(const MarkedEdge&) const = default;
};

/// The pairs that are edges between two faces, each once, by lower vertex, then by upper vertex.
std::vector<MarkedEdge> inner_cuts(const Mesh& mesh, std::span<const VertexPair> pairs, Job& job) {
  std::vector<MarkedEdge> cuts;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if ((k & 0xffff) == 0) job.poll();
    const auto [a, b] = pairs[k];
    const std::int32_t h = find_edge(mesh, a, b);
    if (h == kNone || mesh.opposite(h) == kNone) continue;
    cuts.push_back({{std::min(a, b), std::max(a, b)}, std::min(h, mesh.opposite(h))});
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  return cuts;
}

/// Splits regions one by one, with the faces and the cuts of each in a list.
class Splitter {
 public:
  Splitter(const Mesh& mesh, const Partition& partition, std::vector<MarkedEdge> cuts)
      : mesh_(mesh),
        label_(partition.face_region),
        cuts_(std::move(cuts)),
        is_cut_(3 * static_cast<std::size_t>(mesh.face_count()), 0),
        degree_(static_cast<std::size_t>(mesh.vertex_count()), 0),
        side_(label_.size(), Side::none),
        inside_(static_cast<std::size_t>(partition.region_count())),
        faces_(inside_.size()) {
    for (const MarkedEdge& cut : cuts_) {
      is_cut_[cut.halfedge] = is_cut_[mesh_.opposite(cut.halfedge)] = 1;
      if (const std::int32_t region = region_round(cut); region != kNone) inside_[region].push_back(cut);
    }
    for (std::int32_t f = 0; f < mesh_.face_count(); ++f)
      if (label_[f] != kNone && !inside_[label_[f]].empty()) faces_[label_[f]].push_back(f);
  }

  /// \return whether a region was split
  bool split_all(Job& job) {
    const std::size_t before = faces_.size();
    for (const MarkedEdge& cut : cuts_)
      for (std::int32_t region = region_round(cut); region != kNone; region = region_round(cut)) {
        job.poll();
        split(region, job);
      }
    return faces_.size() > before;
  }
  [[nodiscard]] std::vector<std::int32_t> take_labels() { return std::move(label_); }

 private:
  enum class Side : std::uint8_t { none, left, right };

  /// The region on both sides of a cut; kNone where it is a border.
  [[nodiscard]] std::int32_t region_round(const MarkedEdge& cut) const {
    const std::int32_t region = label_[Mesh::face(cut.halfedge)];
    return region == label_[Mesh::face(mesh_.opposite(cut.halfedge))] ? region : kNone;
  }

  void split(std::int32_t region, Job& job) {
    start(path_in(region));
    spread(region, job);
    const auto fresh = static_cast<std::int32_t>(faces_.size());
    std::vector<std::int32_t> stay, go;
    for (const std::int32_t f : faces_[region]) {
      (side_[f] == Side::right ? go : stay).push_back(f);
      if (side_[f] == Side::right) label_[f] = fresh;
      side_[f] = Side::none;
    }
    faces_[region] = std::move(stay);
    faces_.push_back(std::move(go));
    const std::vector<MarkedEdge> cuts = std::exchange(inside_[region], {});
    inside_.emplace_back();
    for (const MarkedEdge& cut : cuts)
      if (const std::int32_t now = region_round(cut); now != kNone) inside_[now].push_back(cut);
  }

  /// An unbranched path of the cuts inside a region, from the lowest end if there is one, else from the lowest vertex;
  /// as half-edges in the direction of the path. A path of one cut begins at its lower vertex.
  std::vector<std::int32_t> path_in(std::int32_t region) {
    for (const MarkedEdge& cut : inside_[region])
      for (const std::int32_t v : cut.ends) ++degree_[v];
    const MarkedEdge* first = nullptr;
    std::int32_t vertex = kNone;
    bool is_end = false;
    for (const MarkedEdge& cut : inside_[region])
      for (const std::int32_t v : cut.ends) {
        const bool end = degree_[v] == 1;
        if (vertex != kNone && (end != is_end ? is_end : v >= vertex)) continue;
        first = &cut;
        vertex = v;
        is_end = end;
      }
    const std::int32_t begin =
        mesh_.from(first->halfedge) == vertex ? first->halfedge : mesh_.opposite(first->halfedge);
    std::vector<std::int32_t> path{begin};
    while (degree_[mesh_.to(path.back())] == 2) {
      const std::int32_t next = next_cut(path.back(), region);
      if (next == begin) break;
      path.push_back(next);
    }
    for (const MarkedEdge& cut : inside_[region])
      for (const std::int32_t v : cut.ends) degree_[v] = 0;
    if (path.size() == 1 && mesh_.from(begin) > mesh_.to(begin)) path[0] = mesh_.opposite(begin);
    return path;
  }

  /// The next cut of a path through a region, as a half-edge in the direction of the path.
  /// Pre: the path continues at the end of `h`.
  [[nodiscard]] std::int32_t next_cut(std::int32_t h, std::int32_t region) const {
    for (std::int32_t out = turned(mesh_.opposite(h)); out != mesh_.opposite(h); out = turned(out))
      if (is_cut_[out] != 0 && label_[Mesh::face(out)] == region && label_[Mesh::face(mesh_.opposite(out))] == region)
        return out;
    return kNone;  // never, as there are two
  }
  /// The next half-edge that leaves a vertex; past the last one before a border it is the first one.
  [[nodiscard]] std::int32_t turned(std::int32_t h) const {
    const std::int32_t next = mesh_.next_outgoing(h);
    return next == kNone ? mesh_.vertex_halfedge()[mesh_.from(h)] : next;
  }

  /// The faces along a path: of one on both sides the left counts, but the first edge has one face on either side.
  void start(const std::vector<std::int32_t>& path) {
    front_.clear();
    const auto set = [&](std::int32_t h, Side side) {
      if (side_[Mesh::face(h)] == Side::none) front_.push_back(Mesh::face(h));
      side_[Mesh::face(h)] = side;
    };
    for (const std::int32_t h : path) set(mesh_.opposite(h), Side::right);
    for (const std::int32_t h : path) set(h, Side::left);
    set(mesh_.opposite(path[0]), Side::right);
  }

  /// Crosses all edges of the region except cuts; a face that both sides reach in the same step becomes left.
  void spread(std::int32_t region, Job& job) {
    std::vector<std::int32_t> next;
    std::size_t steps = 0;
    while (!front_.empty()) {
      next.clear();
      for (const Side side : {Side::left, Side::right})
        for (const std::int32_t f : front_) {
          if (side_[f] != side) continue;
          if ((++steps & 0xffff) == 0) job.poll();
          for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
            const std::int32_t across = is_cut_[h] ? kNone : mesh_.opposite(h);
            if (across == kNone || label_[Mesh::face(across)] != region) continue;
            if (side_[Mesh::face(across)] != Side::none) continue;
            side_[Mesh::face(across)] = side;
            next.push_back(Mesh::face(across));
          }
        }
      front_.swap(next);
    }
  }

  const Mesh& mesh_;
  std::vector<std::int32_t> label_;
  std::vector<MarkedEdge> cuts_;
  std::vector<std::uint8_t> is_cut_;  // by half-edge
  std::vector<std::int32_t> degree_;  // by vertex, cuts inside a region during the search for a path
  std::vector<Side> side_;            // by face, while a region is split
  std::vector<std::int32_t> front_;
  std::vector<std::vector<MarkedEdge>> inside_;   // by region, in the order of `cuts_`
  std::vector<std::vector<std::int32_t>> faces_;  // by region; empty for regions without the end of a cut
};

}  // namespace

std::int64_t inside_regions(const Mesh& mesh, const Partition& partition, std::span<const VertexPair> edges, Job& job) {
  check_is_of(mesh, partition);
  const std::vector<MarkedEdge> cuts = inner_cuts(mesh, edges, job);
  return std::count_if(cuts.begin(), cuts.end(), [&](const MarkedEdge& cut) {
    const std::int32_t region = partition.face_region[Mesh::face(cut.halfedge)];
    return region != kNone && region == partition.face_region[Mesh::face(mesh.opposite(cut.halfedge))];
  });
}

std::optional<std::vector<std::int32_t>> parted_at(const Mesh& mesh, const Partition& partition,
                                                   std::span<const VertexPair> cuts, Job& job) {
  check_is_of(mesh, partition);
  Splitter splitter(mesh, partition, inner_cuts(mesh, cuts, job));
  if (!splitter.split_all(job)) return std::nullopt;
  return splitter.take_labels();
}

}  // namespace isimp
