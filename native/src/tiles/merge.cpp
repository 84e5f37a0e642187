#include "isimp/tiles/merge.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "borders/relax.h"
#include "checks.h"
#include "components.h"
#include "hierarchy/greedy.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/forest.h"

namespace isimp::tiles {
namespace {

void check(const JoinedGraph& graph) {
  if (graph.length.size() != graph.pair.size())
    throw InvalidInput("there are " + std::to_string(graph.pair.size()) + " pairs, but " +
                       std::to_string(graph.length.size()) + " lengths of borders");
  check_pairs(graph);
}

double area_of(const RegionSum& s) { return s.weight / 2; }

double area_of(std::span<const RegionSum> sums) {
  double area = 0;
  for (const RegionSum& s : sums) area += area_of(s);
  return area;
}

/// Returns the price of a unit of length, as a share of the area.
double price_of_length(const BorderPrice& price, double area) {
  return price.smooth > 0 && area > 0
             ? border_price(price.error, price.smooth) / (2 * std::sqrt(std::max(1, price.proxies)) * std::sqrt(area))
             : 0.0;
}

/// Returns the neighbours of each node as compressed rows. Repeated pairs are separate entries, whose borders add up.
MergeGraph rows_of(const JoinedGraph& graph, double price) {
  MergeGraph rows;
  rows.sum.resize(graph.sum.size());
  rows.first.assign(graph.sum.size() + 1, 0);
  for (const auto& [u, v] : graph.pair) {
    if (u == v) continue;
    ++rows.first[u + 1];
    ++rows.first[v + 1];
  }
  std::partial_sum(rows.first.begin(), rows.first.end(), rows.first.begin());
  rows.neighbour.resize(static_cast<std::size_t>(rows.first.back()));
  if (price > 0) rows.border.resize(rows.neighbour.size());
  std::vector<std::int32_t> next(rows.first.begin(), rows.first.end() - 1);
  for (std::size_t e = 0; e < graph.pair.size(); ++e) {
    const auto [u, v] = graph.pair[e];
    if (u == v) continue;
    for (const auto& [from, to] : {std::pair(u, v), std::pair(v, u)}) {
      const std::int32_t at = next[from]++;
      rows.neighbour[at] = to;
      if (price > 0) rows.border[at] = price * graph.length[e];
    }
  }
  ISIMP_ASSERT(std::ranges::equal(next, std::span(rows.first).subspan(1)), "each node has all its neighbours");
  return rows;
}

}  // namespace

void check_pairs(const JoinedGraph& graph) {
  const auto nodes = static_cast<std::int32_t>(graph.sum.size());
  for (std::size_t e = 0; e < graph.pair.size(); ++e)
    for (const std::int32_t u : graph.pair[e])
      if (u < 0 || u >= nodes)
        throw InvalidInput("pair " + std::to_string(e) + " names node " + std::to_string(u) + ", but there are " +
                           std::to_string(nodes));
}

void check_components(const JoinedGraph& graph, const JoinedComponents& components) {
  if (components.component.size() != graph.sum.size()) throw InvalidInput("there must be one component for each node");
  for (const std::int32_t c : components.component)
    if (c < kNone || c >= static_cast<std::int32_t>(components.need.size()))
      throw InvalidInput("a node is in component " + std::to_string(c) + ", but there are " +
                         std::to_string(components.need.size()));
}

JoinedComponents find_components(const JoinedGraph& graph, std::span<const std::uint8_t> open, std::int32_t proxies,
                                 double leave_out) {
  check(graph);
  const std::size_t nodes = graph.sum.size();
  if (open.size() != nodes) throw InvalidInput("`open` must have one value for each node");
  if (nodes == 0) throw InvalidInput("there are no patches");
  detail::Forest forest(nodes);
  for (const auto& [u, v] : graph.pair) forest.join(u, v);
  JoinedComponents result;
  result.component.assign(nodes, kNone);
  std::vector<Body> bodies;
  std::vector<bool> closed;
  double area = 0;
  for (std::size_t u = 0; u < nodes; ++u) {
    const std::int32_t root = forest.root(static_cast<std::int32_t>(u));
    if (static_cast<std::size_t>(root) == u) {
      result.component[u] = static_cast<std::int32_t>(bodies.size());
      bodies.emplace_back();
      closed.push_back(true);
    }
    const std::int32_t c = result.component[u] = result.component[root];
    bodies[c].area += area_of(graph.sum[u]);
    bodies[c].faces += graph.sum[u].faces;
    if (open[u] != 0) closed[c] = false;
  }
  for (const Body& body : bodies) area += body.area;
  const LeftOut out = choose_left_out(bodies, proxies, leave_out * area);
  result.left_out = out.count;
  result.area_left_out = area > 0 ? out.area / area : 0;
  for (std::size_t c = 0; c < bodies.size(); ++c)
    result.need.push_back(bodies[c].kept ? least_regions(closed[c], bodies[c].faces) : 0);
  for (std::int32_t& c : result.component)
    if (result.need[c] == 0) c = kNone;
  return result;
}

std::vector<std::int32_t> merge(const JoinedGraph& graph, const JoinedComponents& components, std::int32_t target,
                                const BorderPrice& price, Job& job) {
  check(graph);
  check_components(graph, components);
  const double area = area_of(graph.sum), each = price_of_length(price, price.area > 0 ? price.area : area);
  MergeGraph rows = rows_of(graph, each);
  rows.component = components.component;
  std::vector<RegionSum> sums = graph.sum;
  const double unit = area > 0 ? 1 / area : 1;
  for (std::size_t u = 0; u < sums.size(); ++u) {
    sums[u].x *= unit;
    sums[u].y *= unit;
    sums[u].z *= unit;
    if (components.component[u] == kNone) sums[u].faces = 0;  // excluded
    rows.component[u] = std::max(rows.component[u], 0);
  }
  return merge_greedily(rows, sums, components.need, target, job);
}

GroupMerges merge_inside(const JoinedGraph& graph, const JoinedComponents& components,
                         std::span<const std::uint8_t> border, std::int32_t target, double limit,
                         const BorderPrice& price, Job& job) {
  check(graph);
  check_components(graph, components);
  if (border.size() != graph.sum.size()) throw InvalidInput("`border` must have one value for each node");
  const double area = price.area > 0 ? price.area : area_of(graph.sum);
  MergeGraph rows = rows_of(graph, area * price_of_length(price, area));
  rows.component = components.component;
  std::vector<RegionSum> sums = graph.sum;
  for (std::size_t u = 0; u < sums.size(); ++u) {
    if (components.component[u] == kNone) sums[u].faces = 0;  // excluded
    rows.component[u] = std::max(rows.component[u], 0);
  }
  GroupMerges result;
  for (const MergeStep& step : isimp::merge_inside(rows, sums, components.need, border, target, limit, job)) {
    result.merged.push_back({step.into, step.from});
    result.price.push_back(step.price);
  }
  return result;
}

}  // namespace isimp::tiles
