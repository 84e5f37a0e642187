// Decimates a mesh by quadrics (Garland, Heckbert: Surface Simplification Using Quadric Error Metrics, 1997).
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "hybrid.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
};
using OmMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

OpenMesh::VertexHandle handle(std::int32_t vertex) { return OpenMesh::VertexHandle(vertex); }

/// The power of two by which the coordinates come near 1. OpenMesh orders collapses by floats of a squared length, and an
/// unusual unit would leave the range of these.
double scale_to_one(std::span<const Vec3> vertices) {
  double largest = 0;
  for (const Vec3& v : vertices) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  return largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1.0;
}

OmMesh to_openmesh(const Mesh& mesh, Job& job) {
  OmMesh om;
  const double scale = scale_to_one(mesh.vertices());
  om.reserve(static_cast<std::size_t>(mesh.vertex_count()), static_cast<std::size_t>(mesh.face_count()) * 3 / 2,
             static_cast<std::size_t>(mesh.face_count()));
  for (const Vec3& v : mesh.vertices()) om.add_vertex({scale * v.x(), scale * v.y(), scale * v.z()});
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & 0xfff) == 0) job.poll();
    const Triangle& t = mesh.triangles()[f];
    if (!om.add_face(handle(t[0]), handle(t[1]), handle(t[2])).is_valid())
      throw Error("decimating failed: OpenMesh does not take face " + std::to_string(f));
  }
  om.update_face_normals();
  return om;
}

/// No end of a barrier may be removed, so the edge stays.
void lock_barriers(const Surface& surface, OmMesh& om) {
  if (!surface.guided()) return;
  const Mesh& mesh = surface.mesh();
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const FaceGraph& graph = surface.graph();
    if (mesh.opposite(h) == kNone || graph.neighbours[graph.graph_face[Mesh::face(h)]][h % 3] != graph.size()) continue;
    for (const std::int32_t v : {mesh.from(h), mesh.to(h)}) om.status(handle(v)).set_locked(true);
  }
}

class Watch final : public OpenMesh::Decimater::Observer {
 public:
  Watch(Job& job, double collapses) : Observer(256), job_(job), collapses_(collapses) {}
  void notify(std::size_t step) override {
    if (!job_.cancelled()) job_.report(std::min(1.0, static_cast<double>(step) / collapses_));
  }
  [[nodiscard]] bool abort() const override { return job_.cancelled(); }

 private:
  Job& job_;
  double collapses_;
};

Decimated read_back(const OmMesh& om, double fraction) {
  Decimated coarse;
  coarse.fraction = fraction;
  std::vector<std::int32_t> index(om.n_vertices(), kNone);
  for (const auto face : om.all_faces()) {
    if (om.status(face).deleted()) continue;
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto vertex : om.fv_range(face)) {
      std::int32_t& at = index[static_cast<std::size_t>(vertex.idx())];
      if (at == kNone) {
        at = static_cast<std::int32_t>(coarse.vertex.size());
        coarse.vertex.push_back(vertex.idx());
      }
      triangle[corner++] = at;
    }
    coarse.triangles.push_back(triangle);
  }
  return coarse;
}

}  // namespace

Decimated decimate(const Surface& surface, double fraction, Job& job) {
  if (!(fraction > 0 && fraction <= 1))
    throw InvalidInput("fraction must be in (0, 1], got " + std::to_string(fraction));
  const Job::Stage stage(job, "decimating", 0.0, 1.0);
  OmMesh om = to_openmesh(surface.mesh(), job);
  lock_barriers(surface, om);
  const std::size_t faces = om.n_faces();
  const auto wanted = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(faces)));
  using Decimater = OpenMesh::Decimater::DecimaterT<OmMesh>;
  Decimater decimater(om);
  OpenMesh::Decimater::ModQuadricT<OmMesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<OmMesh>::Handle upright;
  decimater.add(quadric);
  decimater.add(upright);
  decimater.module(quadric).unset_max_err();
  decimater.initialize();
  Watch watch(job, static_cast<double>(faces - wanted) / 2 + 1);
  decimater.set_observer(&watch);
  decimater.decimate_to_faces(0, wanted);
  job.poll();
  return read_back(om, fraction);
}

}  // namespace isimp
