#include "isimp/mesh/part_of.h"

#include <string>
#include <utility>
#include <vector>

#include "isimp/core/errors.h"

namespace isimp {
namespace {

/// Makes a mesh of some faces. Where they touch in a vertex alone, the vertex is copied, once for each further fan; a
/// part of a sound mesh needs no other repair.
class PartMaker {
 public:
  PartMaker(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<const std::int32_t> source_face)
      : mesh_(mesh), place_(static_cast<std::size_t>(mesh.face_count()), kNone) {
    for (std::size_t k = 0; k < faces.size(); ++k) {
      std::int32_t& place = place_[faces[k]];
      if (place != kNone) continue;  // named twice
      place = static_cast<std::int32_t>(faces_.size());
      source_face_.push_back(source_face.empty() ? static_cast<std::int32_t>(k) : source_face[k]);
      faces_.push_back(faces[k]);
    }
  }

  Mesh run(Job& job) {
    fan_.assign(3 * faces_.size(), kNone);
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      if ((k & 0xffff) == 0) job.poll();
      for (std::int32_t h = 3 * faces_[k]; h < 3 * faces_[k] + 3; ++h)
        if (fan_[corner(h)] == kNone) walk(h);
    }
    Array<std::int32_t> source_vertex;
    const std::vector<std::int32_t> number = numbered(source_vertex);
    std::vector<Vec3> vertices;
    vertices.reserve(source_vertex.size());
    for (const std::int32_t v : source_vertex) vertices.push_back(mesh_.vertices()[v] + mesh_.origin());
    std::vector<Triangle> triangles(faces_.size());
    for (std::size_t k = 0; k < faces_.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) triangles[k][c] = number[fan_[3 * k + c]];
    return {std::move(vertices),
            std::move(triangles),
            std::move(source_face_),
            std::move(source_vertex),
            RepairReport(),
            mesh_.report().cell,
            Threads(0),
            job};
  }

 private:
  /// The corner of the part at which a half-edge starts; kNone if its face is not in the part.
  [[nodiscard]] std::int32_t corner(std::int32_t h) const {
    const std::int32_t place = h == kNone ? kNone : place_[Mesh::face(h)];
    return place == kNone ? kNone : 3 * place + h % 3;
  }

  /// Numbers the fan at the vertex where a half-edge starts.
  void walk(std::int32_t start) {
    const auto fan = static_cast<std::int32_t>(source_.size());
    source_.push_back(mesh_.from(start));
    std::int32_t h = start, at = corner(start);
    for (; at != kNone && fan_[at] == kNone; at = corner(h)) {
      fan_[at] = fan;
      h = mesh_.next_outgoing(h);
    }
    const auto back = [&](std::int32_t out) {
      const std::int32_t o = mesh_.opposite(out);
      return o == kNone ? kNone : Mesh::next(o);
    };
    h = back(start);
    for (at = corner(h); at != kNone && fan_[at] == kNone; at = corner(h)) {
      fan_[at] = fan;
      h = back(h);
    }
  }

  /// Numbers the fans as vertices: the mesh's vertices in their order, each for its first fan, then the copies.
  std::vector<std::int32_t> numbered(Array<std::int32_t>& source_vertex) const {
    std::vector<std::int32_t> first(static_cast<std::size_t>(mesh_.vertex_count()), kNone), number(source_.size());
    for (std::size_t fan = 0; fan < source_.size(); ++fan)
      if (first[source_[fan]] == kNone) first[source_[fan]] = static_cast<std::int32_t>(fan);
    const auto add = [&](std::size_t fan) {
      number[fan] = static_cast<std::int32_t>(source_vertex.size());
      source_vertex.push_back(source_[fan]);
    };
    for (const std::int32_t fan : first)
      if (fan != kNone) add(static_cast<std::size_t>(fan));
    for (std::size_t fan = 0; fan < source_.size(); ++fan)
      if (first[source_[fan]] != static_cast<std::int32_t>(fan)) add(fan);
    return number;
  }

  const Mesh& mesh_;
  std::vector<std::int32_t> place_;  // (F) of each face in the part; kNone
  std::vector<std::int32_t> faces_;
  Array<std::int32_t> source_face_;
  std::vector<std::int32_t> fan_;     // by corner of the part
  std::vector<std::int32_t> source_;  // by fan: the vertex
};

}  // namespace

Mesh part_of(const Mesh& mesh, std::span<const std::int32_t> faces, Job& job,
             std::span<const std::int32_t> source_face) {
  if (faces.empty()) throw InvalidInput("no face is given");
  for (const std::int32_t f : faces)
    if (f < 0 || f >= mesh.face_count())
      throw InvalidInput("faces must be in [0, " + std::to_string(mesh.face_count()) + "), got " + std::to_string(f));
  return PartMaker(mesh, faces, source_face).run(job);
}

}  // namespace isimp
