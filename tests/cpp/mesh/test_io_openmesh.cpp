#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>

#include "isimp/mesh/clean.h"
#include "isimp/mesh/io.h"
#include "mesh_checks.h"
#include "tests.h"

/// Files are for others: OpenMesh must read the files of this writer, and the other way round.
namespace isimp {
namespace {

using PolyMesh = OpenMesh::PolyMesh_ArrayKernelT<>;

class OpenMeshPeer : public checks::InFolder {};

TEST_F(OpenMeshPeer, ReadsTheWrittenFiles) {
  const PolygonSoup pyramid{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}},
                            {3, 2, 1, 0, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4},
                            {0, 4, 7, 10, 13}};
  for (const char* name : {"a.ply", "a.obj"}) {
    write_polygons(folder_ / name, pyramid.vertices, pyramid.loops, pyramid.loop_start, job());
    PolyMesh mesh;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(mesh, (folder_ / name).string())) << name;
    ASSERT_EQ(mesh.n_vertices(), 5);
    ASSERT_EQ(mesh.n_faces(), 5);
    for (int v = 0; v < 5; ++v)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(mesh.point(OpenMesh::VertexHandle(v))[k], static_cast<float>(pyramid.vertices[v][k]));
    for (int q = 0; q < 5; ++q) {
      std::vector<std::int32_t> corners;
      for (const auto v : mesh.fv_range(OpenMesh::FaceHandle(q))) corners.push_back(v.idx());
      const auto polygon = pyramid.polygon(q);
      EXPECT_TRUE(std::is_permutation(corners.begin(), corners.end(), polygon.begin(), polygon.end()));
    }
  }
}

TEST_F(OpenMeshPeer, IsReadFromEveryKindItWrites) {
  const shapes::Arrays torus = shapes::torus(24, 12);
  PolyMesh mesh;
  for (const Vec3& p : torus.vertices)
    mesh.add_vertex(PolyMesh::Point(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())));
  for (const auto& [a, b, c] : torus.triangles)
    mesh.add_face(OpenMesh::VertexHandle(a), OpenMesh::VertexHandle(b), OpenMesh::VertexHandle(c));
  using OpenMesh::IO::Options;
  const std::vector<std::pair<std::string, Options>> kinds{{"text.ply", Options()},
                                                           {"little.ply", Options(Options::Binary)},
                                                           {"big.ply", Options(Options::Binary | Options::MSB)},
                                                           {"a.obj", Options()},
                                                           {"text.stl", Options()},
                                                           {"binary.stl", Options(Options::Binary)},
                                                           {"a.off", Options()}};
  for (const auto& [name, options] : kinds) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(OpenMesh::IO::write_mesh(mesh, (folder_ / name).string(), options, 9));
    const PolygonSoup soup = read_polygons(folder_ / name, job());
    ASSERT_EQ(soup.polygon_count(), 576);
    for (std::int32_t q = 0; q < 576; ++q)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 p = torus.vertices[torus.triangles[q][k]];
        EXPECT_LT((soup.vertices[soup.polygon(q)[k]] - p).norm(), 1e-6);
      }
    const Mesh sound = clean(soup.vertices, triangulate(soup, job()).triangles, {}, job());
    EXPECT_TRUE(sound.report().closed);
    EXPECT_EQ(sound.report().euler, 0);
  }
}

}  // namespace
}  // namespace isimp
