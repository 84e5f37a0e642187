// Cuts a piece of many holes along one chain of paths.
#include <algorithm>

#include "discs/discs.h"

namespace isimp::meshing {
namespace {

/// A chain in the making: paths that touch no boundary but at their ends, and no vertex twice.
class Chain {
 public:
  Chain(Cutter& cutter, std::int32_t piece, const Shape& shape) : cutter_(cutter), piece_(piece), shape_(shape) {
    const Mesh& mesh = cutter_.labels.mesh;
    outer_ = shape_.longest_loop(mesh);
    cutter_.vertex_marks.clear();
    cutter_.blocked.clear();
    for (std::size_t i = 0; i < shape_.loops.size(); ++i) {
      const auto loop = static_cast<std::int32_t>(i);
      for (const std::int32_t h : shape_.loops[i]) {
        cutter_.vertex_marks.add(mesh.from(h));
        cutter_.vertex_loop[mesh.from(h)] = loop;
      }
    }
    visited_.assign(shape_.loops.size(), false);
    visited_[outer_] = true;
    at_ = outer_;
  }

  /// Extends the chain from loop to loop and back to the outer one, and adds its edges to halfedge_marks.
  /// \return whether the chain is closed
  bool close() {
    cutter_.halfedge_marks.clear();
    for (std::size_t left = shape_.loops.size() - 1; left > 0 && extend(false); --left) {
    }
    return at_ != outer_ && extend(true);
  }

 private:
  /// Adds the shortest path to an unvisited loop, or to the outer one.
  /// \return whether there is one
  bool extend(bool home) {
    Labels& labels = cutter_.labels;
    const Mesh& mesh = labels.mesh;
    Search& search = cutter_.vertices;
    start_search();
    for (std::int32_t v = search.take(); v != kNone; v = search.take()) {
      if (cutter_.vertex_marks.has(v) && search.via[v] != kNone) {
        add_path(v);
        return true;
      }
      for_each_leaving(mesh, v, [&](std::int32_t h) {
        const std::int32_t w = mesh.to(h);
        if (labels.label[h / 3] != piece_ || !labels.inner(h) || cutter_.blocked.has(w)) return;
        if (cutter_.vertex_marks.has(w)) {
          const std::int32_t loop = cutter_.vertex_loop[w];
          if (home ? loop != outer_ : visited_[loop]) return;
        }
        search.reach(w, search.distance[v] + (mesh.vertices()[w] - mesh.vertices()[v]).norm(), h);
      });
    }
    return false;
  }

  /// Starts the search at all vertices of the present loop. Vertices far from the entry of the chain are preferred.
  void start_search() {
    const Mesh& mesh = cutter_.labels.mesh;
    const auto distance = [&](std::int32_t v) {
      return entry_ == kNone ? 0.0 : (mesh.vertices()[v] - mesh.vertices()[entry_]).norm();
    };
    double farthest = 0;
    for (const std::int32_t h : shape_.loops[at_]) farthest = std::max(farthest, distance(mesh.from(h)));
    cutter_.vertices.start();
    for (const std::int32_t h : shape_.loops[at_])
      if (!cutter_.blocked.has(mesh.from(h)))
        cutter_.vertices.reach(mesh.from(h), farthest - distance(mesh.from(h)), kNone);
  }

  void add_path(std::int32_t end) {
    const Mesh& mesh = cutter_.labels.mesh;
    at_ = cutter_.vertex_loop[end];
    visited_[at_] = true;
    entry_ = end;
    for (std::int32_t v = end;;) {
      cutter_.blocked.add(v);
      const std::int32_t h = cutter_.vertices.via[v];
      if (h == kNone) break;
      cutter_.halfedge_marks.add(h);
      cutter_.halfedge_marks.add(mesh.opposite(h));
      v = mesh.from(h);
    }
  }

  Cutter& cutter_;
  const std::int32_t piece_;
  const Shape& shape_;
  std::int32_t outer_ = 0, at_ = 0;
  std::int32_t entry_ = kNone;  // where the chain came into the present loop
  std::vector<bool> visited_;
};

}  // namespace

std::int32_t cut_chain(Cutter& cutter, std::int32_t piece, const Shape& shape) {
  Labels& labels = cutter.labels;
  if (!Chain(cutter, piece, shape).close()) return kNone;
  const std::vector<std::int32_t> faces = labels.faces_of(piece);
  std::vector<std::int32_t> side{faces[0]};
  cutter.face_marks.clear();
  cutter.face_marks.add(faces[0]);
  for (std::size_t i = 0; i < side.size(); ++i)
    for (std::int32_t h = 3 * side[i], end = h + 3; h < end; ++h) {
      if (!labels.inner(h) || cutter.halfedge_marks.has(h)) continue;
      const std::int32_t g = labels.mesh.opposite(h) / 3;
      if (cutter.face_marks.add(g)) side.push_back(g);
    }
  if (side.size() == faces.size()) return kNone;
  const auto other = std::find_if(faces.begin(), faces.end(), [&](auto f) { return !cutter.face_marks.has(f); });
  return labels.part(side, *other, Cause::hole);
}

}  // namespace isimp::meshing
