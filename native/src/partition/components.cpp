#include "components.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "isimp/core/check.h"

namespace isimp {
namespace {

constexpr std::int32_t kClosedNeed = 4;  // unit: a closed surface of planar polygons has at least four
// tuned real
constexpr double kTogether = 10.0;      // all components left out stay below this times `leave_out`,
constexpr double kUnseenTogether = 20;  // or below this if each of the others is too small to be seen:
constexpr double kUnseen = 0.1;         // share of the mean area of a region

/// Sets all members except `kept` and `need`.
std::vector<Component> measure(const Surface& surface, Job& job) {
  const FaceGraph& graph = surface.graph();
  const std::int32_t n = graph.size();
  std::vector<Component> components(static_cast<std::size_t>(surface.component_count()));
  const std::int32_t* number = surface.component_count() > 1 ? surface.component().data() : nullptr;
  Component run;  // faces near in the graph are mostly of one component: sum up a run before touching its own sum
  std::int32_t of_run = 0;
  const auto close = [&] {
    Component& component = components[of_run];
    component.sum.add(run.sum);
    component.area += run.area;
    component.closed &= run.closed;
    run = Component{};
  };
  for (std::int32_t i = 0; i < n; ++i) {
    if ((i & 0xffff) == 0) job.poll();
    const std::int32_t c = number == nullptr ? 0 : number[graph.mesh_face[i]];
    if (c != of_run) {
      close();
      of_run = c;
    }
    run.sum.add(graph.faces[i]);
    run.area += graph.faces[i].area;
    const auto& around = graph.neighbours[i];
    run.closed &= around[0] != n && around[1] != n && around[2] != n;
  }
  close();
  return components;
}

/// Components of the mesh. Barriers may have cut one into several parts, but it is left out as one, without its
/// weights.
std::vector<Body> bodies_of(const Surface& surface, const Components& components) {
  std::vector<Body> bodies;
  const Mesh& mesh = surface.mesh();
  if (&surface.graph() == &mesh.graph()) {
    for (const Component& component : components.all) bodies.push_back({component.area, component.sum.faces});
    return bodies;
  }
  bodies.resize(static_cast<std::size_t>(mesh.component_count()));
  for (std::int32_t i = 0; i < mesh.face_count(); ++i) {
    Body& body = bodies[mesh.component()[mesh.graph().mesh_face[i]]];
    body.area += mesh.graph().faces[i].area;
    ++body.faces;
  }
  return bodies;
}

}  // namespace

LeftOut choose_left_out(std::vector<Body>& bodies, std::int32_t proxies, double leave_out) {
  std::vector<std::int32_t> order(bodies.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return std::pair(bodies[a].area, a) < std::pair(bodies[b].area, b);
  });
  order.pop_back();  // the largest is always kept
  std::int64_t faces = 0;
  double area = 0;
  for (const Body& body : bodies) {
    faces += body.faces;
    area += body.area;
  }
  const double unseen = proxies > 1 ? kUnseen * area / proxies : 0.0;
  LeftOut out;
  for (const std::int32_t c : order) {
    Body& body = bodies[c];
    const double together = body.area < unseen ? kUnseenTogether : kTogether;
    if (body.area >= leave_out || out.area + body.area >= together * leave_out) break;
    if (faces - body.faces < proxies) break;
    body.kept = false;
    faces -= body.faces;
    out.area += body.area;
    ++out.count;
  }
  return out;
}

std::int32_t least_regions(bool closed, std::int64_t faces) {
  return static_cast<std::int32_t>(std::min<std::int64_t>(closed ? kClosedNeed : 1, faces));
}

Components find_components(const Surface& surface, std::int32_t proxies, double leave_out, Job& job,
                           std::vector<Component> measured) {
  Components components;
  components.all = measured.empty() ? measure(surface, job) : std::move(measured);
  components.asked = proxies;
  std::vector<Body> bodies = bodies_of(surface, components);
  const LeftOut out = choose_left_out(bodies, proxies, leave_out);
  components.left_out = out.count;
  components.area_left_out = out.area;
  if (bodies.size() == components.all.size())
    for (std::size_t c = 0; c < bodies.size(); ++c) components.all[c].kept = bodies[c].kept;
  else if (components.left_out > 0)
    for (std::int32_t f = 0; f < surface.face_count(); ++f)
      components.all[surface.component()[f]].kept = bodies[surface.mesh().component()[f]].kept;
  for (Component& component : components.all) {
    component.need = component.kept ? least_regions(component.closed, component.sum.faces) : 0;
    components.needed += component.need;
  }
  return components;
}

std::vector<std::int32_t> share_out(const Components& components) {
  const std::size_t count = components.all.size();
  std::vector<std::int32_t> share(count);
  std::vector<double> weight(count);
  for (std::size_t c = 0; c < count; ++c) {
    share[c] = components.all[c].need;
    weight[c] = components.all[c].kept ? std::sqrt(components.all[c].sum.error()) : 0.0;
  }
  // Where all components are flat the rest is divided by size.
  if (std::accumulate(weight.begin(), weight.end(), 0.0) < 1e-6)
    for (std::size_t c = 0; c < count; ++c) weight[c] = components.all[c].kept ? components.all[c].sum.faces : 0.0;

  // The ideal share of a component is t * weight, held between its need and its faces; t is found by halving.
  const std::int32_t target = components.regions();
  const auto ideal = [&](double t, std::size_t c) {
    return std::clamp<double>(t * weight[c], components.all[c].need,
                              components.all[c].kept ? components.all[c].sum.faces : 0);
  };
  double low = 0.0, high = 1.0;
  const auto total = [&](double t) {
    double sum = 0.0;
    for (std::size_t c = 0; c < count; ++c) sum += ideal(t, c);
    return sum;
  };
  while (total(high) < target && high < 1e18) high *= 2;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (total(middle) < target ? low : high) = middle;
  }
  std::vector<std::pair<double, std::int32_t>> remainder;  // most first
  std::int32_t given = 0;
  for (std::size_t c = 0; c < count; ++c) {
    share[c] = std::max(share[c], static_cast<std::int32_t>(ideal(low, c)));
    given += share[c];
    remainder.emplace_back(share[c] - ideal(low, c), static_cast<std::int32_t>(c));
  }
  std::sort(remainder.begin(), remainder.end());
  // Several laps only if weights of zero hold most faces: these then fill up one by one.
  while (given < target)
    for (const auto& [unused, c] : remainder) {
      if (given == target) break;
      if (!components.all[c].kept || share[c] >= components.all[c].sum.faces) continue;
      ++share[c];
      ++given;
    }
  ISIMP_ASSERT(std::accumulate(share.begin(), share.end(), 0) == std::max(given, target), "all regions are shared out");
  return share;
}

}  // namespace isimp
