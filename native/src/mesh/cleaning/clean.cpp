#include "isimp/mesh/clean.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "cleaning/close.h"
#include "cleaning/grid.h"
#include "cleaning/inside.h"
#include "cleaning/stitch.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/forest.h"
#include "isimp/mesh/found_opening.h"
#include "surface/soup.h"

namespace isimp::detail {

/// Arrays that are sound, before small openings are closed.
struct Cleaning {
  MeshArrays arrays;
  Topology topology;
  RepairLog log;
  MeshArrays aside = {};  ///< arrays of components that stay as they are

  /// Closes the openings that the options name, and makes the mesh.
  Cleaned finish(const CleanOptions& options, const std::vector<Vec3>& keep, const Threads& threads, Job& job) &&;
};

namespace {

void check(std::size_t vertices, const std::vector<Triangle>& triangles, const CleanOptions& options,
           const Threads& threads) {
  check_fields(options);
  if (triangles.empty()) throw InvalidInput("the mesh has no faces");
  const auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (triangles.size() > most / 3 || vertices > most)
    throw InvalidInput("the mesh has " + std::to_string(triangles.size()) + " faces and " + std::to_string(vertices) +
                       " vertices; at most 715,827,882 and 2,147,483,647 are supported");
  const auto n = static_cast<std::int32_t>(vertices);
  const auto out_of_range = [n](std::int32_t i) { return i < 0 || i >= n; };
  const auto f = find_first(threads, triangles.size(), [&](std::size_t i) {
    return std::any_of(triangles[i].begin(), triangles[i].end(), out_of_range);
  });
  if (f == triangles.size()) return;
  const std::int32_t v = *std::find_if(triangles[f].begin(), triangles[f].end(), out_of_range);
  throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(v) + ", but there are " +
                     std::to_string(n) + " vertices");
}

/// Makes the soup manifold and oriented: duplicates, welding, orientation, non-manifold edges and vertices.
/// \param welded  whether borders were welded already
MeshArrays take_apart(Soup& soup, double tolerance, bool welded, Job& job) {
  const auto group = [&] { return EdgeGroups(soup.vertices.size(), soup.faces(), job); };
  EdgeGroups edges = group();
  if (drop_duplicates(soup, edges, job)) edges = group();
  if (!welded && weld(soup, border_vertices(soup, edges, job), tolerance, job)) {
    edges = group();
    if (drop_duplicates(soup, edges, job)) edges = group();
  }
  job.report(0.6);
  const Undecided undecided = join_simple_edges(soup, edges, job);
  const std::vector<char> reversed = orient(soup, undecided.same_way, job);
  join_non_manifold_edges(soup, undecided.non_manifold, reversed);
  reverse_faces(soup, reversed);
  edges = EdgeGroups(0, {}, job);  // its memory is wanted
  return separate(soup, job);
}

Cleaning make_manifold(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options,
                       const Threads& threads, Job& job) {
  check(vertices.size(), triangles, options, threads);
  Soup soup;
  soup.vertices = std::move(vertices);
  soup.named = std::move(triangles);
  drop_broken(soup, threads, job);

  MeshArrays arrays;
  bool welded = false, sound = false;
  Topology topology;
  {
    const Job::Stage stage(job, "cleaning", 0.0, 0.5);
    const auto look = [&](double from, double to) {
      const Job::Stage edges(job, "cleaning", from, to);
      topology = find_topology(soup.vertices.size(), soup.faces(), threads, job);
      sound = topology.defect.empty() && !has_twins(topology, threads);
    };
    look(0.0, 0.8);
    if (sound) welded = weld(soup, border_vertices(soup, topology), options.weld, job);
    if (welded) look(0.8, 1.0);
    if (sound) {
      arrays = compact(soup, topology, threads, job);
    } else {
      topology = {};
      arrays = take_apart(soup, options.weld, welded, job);
    }
  }
  if (arrays.triangles.empty())
    throw InvalidInput(
        "no usable face is left: after vertices at the same position were welded, no face has three different ones");
  if (!sound) topology = find_topology(arrays.vertices.size(), arrays.triangles, threads, job);
  if (!topology.defect.empty()) throw Error("cleaning left " + topology.defect);
  flip_degenerate_edges(arrays, topology, soup.log, threads, job);
  return {std::move(arrays), std::move(topology), std::move(soup.log)};
}

/// The number of connected components of the triangles.
std::int32_t components(const MeshArrays& arrays) {
  Forest forest(arrays.vertices.size());
  for (const Triangle& t : arrays.triangles) {
    forest.join(t[0], t[1]);
    forest.join(t[0], t[2]);
  }
  return static_cast<std::int32_t>(
      std::count_if(arrays.triangles.begin(), arrays.triangles.end(),
                    [&, seen = std::vector<char>(arrays.vertices.size(), 0)](const Triangle& t) mutable {
                      return std::exchange(seen[forest.root(t[0])], 1) == 0;
                    }));
}

/// The borders of chunks joined, in two passes: joining makes faces that are not manifold, and these are repaired.
void stitch_chunks(Cleaning& sound, const CleanOptions& options, const Threads& threads, Job& job) {
  std::optional<double> distance = options.stitch;
  for (int pass = 0; pass < 2; ++pass) {
    RepairLog log = sound.log;
    std::optional<Stitched> joined = stitch(sound.arrays, sound.topology, distance, log, job);
    if (!joined) return;
    Cleaning next = make_manifold(std::move(joined->vertices), std::move(joined->triangles),
                                  {.threads = options.threads}, threads, job);
    // Drawn models of large triangles have borders near each other that belong to no chunks.
    if (!distance && components(next.arrays) >= components(sound.arrays)) return;
    sound.log = std::move(log);
    const auto through = [](Array<std::int32_t>& names, const auto& before, std::size_t count) {
      if (before.empty()) return;
      if (names.empty()) {
        names.resize(count);
        std::iota(names.begin(), names.end(), 0);
      }
      for (std::int32_t& name : names)
        if (name != kNone) name = before[name];
    };
    std::vector<std::int32_t> face = std::move(joined->source_face);
    if (!sound.arrays.source_face.empty())
      for (std::int32_t& f : face) f = sound.arrays.source_face[f];
    through(next.arrays.source_face, face, next.arrays.triangles.size());
    through(next.arrays.source_vertex, sound.arrays.source_vertex, next.arrays.vertices.size());
    sound.log.add_orientation(next.log, face);
    sound.arrays = std::move(next.arrays);
    sound.topology = std::move(next.topology);
    if (!distance) distance = joined->distance;
  }
}

/// Moves the marked faces, which are whole components, to arrays of their own.
MeshArrays take_aside(MeshArrays& arrays, std::span<const std::uint8_t> marked) {
  std::vector<std::uint8_t> goes(arrays.vertices.size(), 0);
  for (std::size_t f = 0; f < marked.size(); ++f)
    if (marked[f] != 0)
      for (const std::int32_t v : arrays.triangles[f]) goes[v] = 1;
  MeshArrays rest, aside;
  std::vector<std::int32_t> number(goes.size());
  for (std::size_t v = 0; v < goes.size(); ++v) {
    MeshArrays& to = goes[v] != 0 ? aside : rest;
    number[v] = static_cast<std::int32_t>(to.vertices.size());
    to.vertices.push_back(arrays.vertices[v]);
    to.source_vertex.push_back(arrays.source_vertex[v]);
  }
  for (std::size_t f = 0; f < marked.size(); ++f) {
    MeshArrays& to = marked[f] != 0 ? aside : rest;
    const auto& [a, b, c] = arrays.triangles[f];
    to.triangles.push_back({number[a], number[b], number[c]});
    to.source_face.push_back(arrays.source_face[f]);
  }
  rest.cell = arrays.cell;
  arrays = std::move(rest);
  return aside;
}

/// Removes the components inside closed ones.
void drop_inside(Cleaning& sound, const Threads& threads, Job& job) {
  const std::vector<std::uint8_t> marks = inner_faces(sound.arrays, sound.topology, job);
  if (marks.empty()) return;
  const auto numbers = [](Array<std::int32_t>& names, std::size_t count) {
    if (!names.empty()) return;
    names.resize(count);
    std::iota(names.begin(), names.end(), 0);
  };
  numbers(sound.arrays.source_face, sound.arrays.triangles.size());
  numbers(sound.arrays.source_vertex, sound.arrays.vertices.size());
  for (const std::int32_t f : take_aside(sound.arrays, marks).source_face) sound.log.add(RepairKind::inner_faces, f);
  sound.topology = find_topology(sound.arrays.vertices.size(), sound.arrays.triangles, threads, job);
}

Cleaning make_sound(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options,
                    const Threads& threads, Job& job) {
  Cleaning sound = make_manifold(std::move(vertices), std::move(triangles), options, threads, job);
  stitch_chunks(sound, options, threads, job);
  if (options.outside_only) drop_inside(sound, threads, job);
  smooth_steps(sound.arrays, sound.topology, options.grid, sound.log, threads, job);
  return sound;
}

/// The arrays of a mesh.
MeshArrays arrays_of(const Mesh& mesh) {
  MeshArrays arrays;
  arrays.vertices.assign(mesh.vertices().begin(), mesh.vertices().end());
  if (!mesh.origin().isZero(0))
    for (Vec3& v : arrays.vertices) v += mesh.origin();
  arrays.triangles.assign(mesh.triangles().begin(), mesh.triangles().end());
  arrays.source_face.assign(mesh.source_face().begin(), mesh.source_face().end());
  arrays.source_vertex.assign(mesh.source_vertex().begin(), mesh.source_vertex().end());
  arrays.cell = mesh.report().cell;
  return arrays;
}

/// Adds the arrays of other components at the end.
void append(const MeshArrays& more, MeshArrays& arrays, Topology& topology, const Threads& threads, Job& job) {
  const auto vertices = static_cast<std::int32_t>(arrays.vertices.size());
  const auto halfedges = static_cast<std::int32_t>(3 * arrays.triangles.size());
  const Topology own = find_topology(more.vertices.size(), more.triangles, threads, job);
  arrays.vertices.insert(arrays.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const std::int32_t v : more.source_vertex) arrays.source_vertex.push_back(v);
  for (const auto& [a, b, c] : more.triangles) arrays.triangles.push_back({a + vertices, b + vertices, c + vertices});
  for (const std::int32_t f : more.source_face) arrays.source_face.push_back(f);
  const auto shifted = [&](std::int32_t h) { return h == kNone ? kNone : h + halfedges; };
  for (const std::int32_t h : own.opposite) topology.opposite.push_back(shifted(h));
  for (const std::int32_t h : own.vertex_halfedge) topology.vertex_halfedge.push_back(shifted(h));
  for (const std::int32_t h : own.border) topology.border.push_back(shifted(h));
  topology.unused_vertices += own.unused_vertices;
}

/// The arrays of a mesh, so that its openings can be closed.
/// \param aside  see close_openings
Cleaning sound_of(const Mesh& mesh, std::span<const std::uint8_t> aside, const Threads& threads, Job& job) {
  const Job::Stage stage(job, "cleaning", 0.0, 0.5);
  Cleaning sound{.arrays = arrays_of(mesh), .topology = {}, .log = RepairLog(mesh.report().repairs)};
  if (!aside.empty()) sound.aside = take_aside(sound.arrays, aside);
  sound.topology = find_topology(sound.arrays.vertices.size(), sound.arrays.triangles, threads, job);
  return sound;
}

void check(const std::vector<Vec3>& keep) {
  for (const Vec3& place : keep)
    if (!place.allFinite()) throw InvalidInput("a place of an opening to keep has a coordinate that is not finite");
}

}  // namespace

Cleaned Cleaning::finish(const CleanOptions& options, const std::vector<Vec3>& keep, const Threads& threads,
                         Job& job) && {
  std::vector<FoundOpening> found;
  const bool closing = options.fill_holes > 0 || options.fill_flat_holes > 0 || options.cut_handles > 0;
  if (closing) {
    const Job::Stage stage(job, "closing holes", 0.5, 0.75);
    found = close_small(arrays, topology, options, keep, log, threads, job);
  }
  const Job::Stage stage(job, "cleaning", closing ? 0.75 : 0.5, 1.0);
  if (!aside.triangles.empty()) append(aside, arrays, topology, threads, job);
  return {Mesh(std::move(arrays), std::move(topology), log.take(), threads, job), std::move(found)};
}

}  // namespace isimp::detail

namespace isimp {

Mesh clean(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options, Job& job) {
  return clean_keeping(std::move(vertices), std::move(triangles), options, {}, job).mesh;
}

Cleaned clean_keeping(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options,
                      const std::vector<Vec3>& keep, Job& job) {
  detail::check(keep);
  const Threads threads(options.threads);
  return detail::make_sound(std::move(vertices), std::move(triangles), options, threads, job)
      .finish(options, keep, threads, job);
}

Cleaned close_openings(const Mesh& mesh, const CleanOptions& options, const std::vector<Vec3>& keep, Job& job,
                       std::span<const std::uint8_t> aside) {
  check_fields(options);
  detail::check(keep);
  ISIMP_ASSERT(aside.empty() || aside.size() == static_cast<std::size_t>(mesh.face_count()), "one mark a face");
  const Threads threads(options.threads);
  return detail::sound_of(mesh, aside, threads, job).finish(options, keep, threads, job);
}

}  // namespace isimp
