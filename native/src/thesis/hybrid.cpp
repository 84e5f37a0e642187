#include "hybrid.h"

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "borders/relax.h"
#include "flooding.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/errors.h"
#include "isimp/partition/metric.h"
#include "make_partition.h"
#include "methods.h"
#include "rounds.h"

namespace isimp {
namespace {

constexpr int kDenseSweeps = 60;  // limit: sweeps of the borders on the dense mesh

/// The coarse mesh without the components that are left out, and the way back to the dense one.
struct Coarse {
  Mesh mesh;
  std::vector<std::int32_t> vertex;  ///< (V) vertex of the dense mesh
  Guides guides;
};

template <class Visit>
void for_faces_round(const Mesh& mesh, std::int32_t vertex, Visit visit) {
  const std::int32_t start = mesh.vertex_halfedge()[vertex];
  for (std::int32_t h = start; h != kNone;) {
    visit(Mesh::face(h));
    h = mesh.next_outgoing(h);
    if (h == start) break;
  }
}

/// The guides for the coarse mesh: barriers are edges of both, and the weight of a vertex is that of the faces around
/// it.
Guides guides_of(const Surface& surface, std::span<const std::int32_t> coarse_of, const Mesh& coarse,
                 std::span<const std::int32_t> dense_of) {
  Guides guides;
  if (!surface.guided()) return guides;
  const Mesh& mesh = surface.mesh();
  const FaceGraph& graph = surface.graph();
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const std::int32_t other = mesh.opposite(h);
    if (other < h || graph.neighbours[graph.graph_face[Mesh::face(h)]][h % 3] != graph.size()) continue;
    const std::int32_t a = coarse_of[mesh.from(h)], b = coarse_of[mesh.to(h)];
    if (a != kNone && b != kNone) guides.barriers.push_back({a, b});  // both, or its component is left out
  }
  if (surface.weight().empty()) return guides;
  const auto weight_at = [&](std::int32_t vertex) {
    double sum = 0.0;
    int faces = 0;
    for_faces_round(mesh, vertex, [&](std::int32_t f) {
      sum += surface.weight()[graph.graph_face[f]];
      ++faces;
    });
    return sum / faces;
  };
  for (const Triangle& t : coarse.triangles())
    guides.weights.push_back((weight_at(dense_of[t[0]]) + weight_at(dense_of[t[1]]) + weight_at(dense_of[t[2]])) / 3);
  return guides;
}

Coarse make_coarse(const Surface& surface, const Decimated& all, const Components& components, Job& job) {
  const Mesh& mesh = surface.mesh();
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> dense_of, coarse_of(mesh.vertices().size(), kNone);
  for (const Triangle& t : all.triangles) {
    Triangle mine{};
    // A face by its first corner: a component of the mesh is left out as a whole, also if barriers divide it.
    if (!components.all[surface.component()[Mesh::face(mesh.vertex_halfedge()[all.vertex[t[0]]])]].kept) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t dense = all.vertex[t[k]];
      if (coarse_of[dense] == kNone) {
        coarse_of[dense] = static_cast<std::int32_t>(dense_of.size());
        dense_of.push_back(dense);
        vertices.push_back(mesh.vertices()[dense]);
      }
      mine[k] = coarse_of[dense];
    }
    triangles.push_back(mine);
  }
  Mesh coarse(std::move(vertices), std::move(triangles), job);
  Guides guides = guides_of(surface, coarse_of, coarse, dense_of);
  return {std::move(coarse), std::move(dense_of), std::move(guides)};
}

/// The starts of the coarse mesh's proxies on the dense one.
class Carrier {
 public:
  Carrier(const Surface& surface, const Components& components) : surface_(surface), components_(components) {
    taken_.assign(static_cast<std::size_t>(surface.graph().size()) + 1, false);
    taken_.back() = true;  // the sentinel is no face to start at
    for (std::int32_t i = 0; i < surface.graph().size(); ++i)
      if (!components.all[component(i)].kept) taken_[i] = true;
  }

  void carry(const Coarse& coarse, const Partition& part) {
    for (std::int32_t r = 0; r < part.region_count(); ++r) {
      const Vec3& n = part.region_normal[r];
      proxies.push_back({static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())});
      seeds.push_back(free_near(look_alike(coarse, part.region_seed[r], proxies.back())));
      taken_[seeds.back()] = true;
    }
    give_to_empty_components();
  }

  std::vector<std::int32_t> seeds;  ///< (R) distinct graph indices
  std::vector<NormalMetric::Proxy> proxies;

 private:
  [[nodiscard]] std::int32_t component(std::int32_t i) const {
    return surface_.component()[surface_.graph().mesh_face[i]];
  }

  /// The face most like the proxy among the dense faces at the corners of a coarse face; corners on barriers, which lie
  /// in two components, count only if there are no others.
  [[nodiscard]] std::int32_t look_alike(const Coarse& coarse, std::int32_t face,
                                        const NormalMetric::Proxy& proxy) const {
    const FaceGraph& graph = surface_.graph();
    using Best = std::pair<float, std::int32_t>;
    const Best none{std::numeric_limits<float>::infinity(), kNone};
    Best inside = none, any = none;
    for (const std::int32_t v : coarse.mesh.triangles()[face]) {
      Best best = none;
      std::int32_t least = graph.size(), largest = -1;  // components met
      for_faces_round(surface_.mesh(), coarse.vertex[v], [&](std::int32_t f) {
        const std::int32_t i = graph.graph_face[f];
        best = std::min(best, {NormalMetric::error(graph.faces[i], proxy), i});
        least = std::min(least, component(i));
        largest = std::max(largest, component(i));
      });
      any = std::min(any, best);
      if (least == largest) inside = std::min(inside, best);
    }
    return inside.second != kNone ? inside.second : any.second;
  }

  /// That face, or the next free one, outwards in its component; else any free face.
  [[nodiscard]] std::int32_t free_near(std::int32_t face) const {
    std::vector<std::int32_t> reached{face};
    std::set<std::int32_t> seen{face};
    for (std::size_t k = 0; k < reached.size(); ++k) {
      if (!taken_[reached[k]]) return reached[k];
      for (const std::int32_t j : surface_.graph().neighbours[reached[k]])
        if (j != surface_.graph().size() && seen.insert(j).second) reached.push_back(j);
    }
    return static_cast<std::int32_t>(std::find(taken_.begin(), taken_.end(), false) - taken_.begin());
  }

  /// Barriers may leave components so small that no coarse face lies in them.
  void give_to_empty_components() {
    std::vector<std::int32_t> count(components_.all.size(), 0), first(components_.all.size(), 0);
    for (std::int32_t i = surface_.graph().size() - 1; i >= 0; --i) first[component(i)] = i;
    for (const std::int32_t seed : seeds) ++count[component(seed)];
    for (std::size_t c = 0; c < count.size(); ++c) {
      if (!components_.all[c].kept || count[c] > 0) continue;
      const auto most = std::max_element(count.begin(), count.end()) - count.begin();
      std::size_t r = seeds.size() - 1;
      while (component(seeds[r]) != most) --r;
      seeds[r] = first[c];
      proxies[r] = NormalMetric::proxy_of(surface_.graph().faces[seeds[r]]);
      --count[static_cast<std::size_t>(most)];
      ++count[c];
    }
  }

  const Surface& surface_;
  const Components& components_;
  std::vector<bool> taken_;  // (n + 1)
};

}  // namespace

Partition hybrid(const Surface& surface, const Decimated& all, const PartitionOptions& options, Job& job) {
  const Job::Stage stage(job, "partitioning", 0.0, 1.0);
  const Components components = find_components(surface, *options.proxies, options.leave_out, job);
  const Coarse coarse = make_coarse(surface, all, components, job);
  if (coarse.mesh.face_count() < components.regions())
    throw InvalidInput("the mesh has " + std::to_string(coarse.mesh.face_count()) + " faces left at fraction " +
                       std::to_string(all.fraction) + ", too few for " + std::to_string(components.regions()) +
                       " regions");
  PartitionOptions plain = options;
  const bool faithful = options.connect == Connect::flood;
  plain.method = faithful ? Method::lloyd : Method::hierarchy;
  plain.metric = Metric::normals;
  plain.proxies = components.regions();
  plain.leave_out = 0.0;
  Carrier carrier(surface, components);
  {
    const Job::Stage rounds(job, "flooding", 0.0, 0.9);
    const Surface coarse_surface(coarse.mesh, coarse.guides, job);
    const Hierarchy hierarchy = needs_hierarchy(plain)
                                    ? build_hierarchy(coarse_surface, *plain.proxies, job,
                                                      {.threads = plain.threads, .coarsest = nodes_for(*plain.proxies)})
                                    : Hierarchy{};
    carrier.carry(coarse, faithful ? in_rounds(coarse_surface, hierarchy, nullptr, plain, job)
                                   : by_number(coarse_surface, hierarchy, plain, job));
  }
  const Job::Stage carrying(job, "carrying back", 0.9, 1.0);
  Regions regions;
  Flooding().run(surface.graph(), carrier.proxies, carrier.seeds, regions.label, job);
  regions.sum.resize(carrier.seeds.size());
  sum_regions(surface.graph(), regions, job);
  const Threads threads(options.threads);
  if (!faithful) {
    // The borders begin as those of the coarse mesh, where they were smoothed. Relaxing moves them on the dense mesh.
    const BorderWeight weight{0.5 * light_border_weight(regions.error()).edge};
    relax_borders(surface.graph(), regions, weight, kDenseSweeps, threads, job);
  }
  return make_partition(surface, components, regions, {regions.error()}, threads, job);
}

}  // namespace isimp
