// A mesh is the same, bit for bit, on any number of threads.
#include <bit>

#include "isimp/mesh/clean.h"
#include "isimp/mesh/mesh.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

/// A ring of more faces than three threads leave to one of them, an open sheet and many small boxes, in an order in
/// which neighbours are far apart.
Arrays many_parts() {
  Arrays boxes = shapes::cube(1);
  for (int i = 1; i < 40; ++i) boxes = shapes::both(boxes, shapes::cube(1), Vec3(0, 2 * i, 0));
  Arrays a = shapes::both(shapes::torus(300, 200, 0.3), shapes::plane(60), {3, 0, 0});
  a = shapes::both(a, boxes, {0, 5, 0});
  const std::size_t n = a.triangles.size();
  std::vector<Triangle> mixed;
  for (std::size_t i = 0; i < n; ++i) mixed.push_back(a.triangles[i * 7919 % n]);  // a prime that does not divide n
  a.triangles = mixed;
  return a;
}

/// `many_parts` with the damage of a scanner: each kind of defect that `clean` searches for in all faces.
Arrays damaged_parts() {
  Arrays a = many_parts();
  a.triangles[50'000] = {1, 1, 2};
  a.triangles[60'001] = a.triangles[100];
  a.vertices[a.triangles[110'000][0]] = Vec3(std::nan(""), 0, 0);
  a.vertices[a.triangles[90'000][0]] = a.vertices[a.triangles[90'000][1]];  // faces without area
  a.vertices.push_back({7, 7, 7});                                          // used by no face
  std::swap(a.triangles[20'000][0], a.triangles[20'000][1]);
  return a;
}

template <class Values>
std::string bits(const Values& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(*values.data())};
}

/// The contents of a mesh, in bytes.
std::vector<std::string> bits_of(const Mesh& mesh) {
  const FaceGraph& g = mesh.graph();
  const MeshReport& r = mesh.report();
  std::vector<std::string> all{
      bits(mesh.vertices()),      bits(mesh.triangles()), bits(mesh.source_face()),
      bits(mesh.source_vertex()), bits(mesh.opposite()),  bits(mesh.vertex_halfedge()),
      bits(mesh.component()),     bits(g.faces),          bits(g.neighbours),
      bits(g.mesh_face),          bits(g.graph_face),     bits(std::vector{g.area, r.diagonal})};
  all.push_back(bits(std::vector<std::int64_t>{r.components, r.closed_components, r.border_edges, r.border_loops,
                                               r.unused_vertices, r.zero_area_faces, r.euler}));
  for (const Repair& repair : r.repairs) all.push_back(repair.what + std::to_string(repair.count) + bits(repair.where));
  return all;
}

TEST(MeshThreads, AMeshIsTheSameOnAnyNumberOfThem) {
  const Arrays a = many_parts();
  const Mesh one(a.vertices, a.triangles, job(), 1);
  EXPECT_EQ(one.component_count(), 42);
  EXPECT_EQ(one.report().closed_components, 41);
  EXPECT_EQ(one.report().border_edges, 4 * 60);
  for (const std::int32_t threads : {2, 3, 7, 0})
    EXPECT_EQ(bits_of(Mesh(a.vertices, a.triangles, job(), threads)), bits_of(one)) << threads << " threads";
}

TEST(MeshThreads, ACleanedMeshIsTheSameOnAnyNumberOfThem) {
  const Arrays a = damaged_parts();
  const auto cleaned = [&](std::int32_t threads) {
    return clean(a.vertices, a.triangles, {.threads = threads}, job());
  };
  const std::vector<std::string> one = bits_of(cleaned(1));
  for (const std::int32_t threads : {2, 3, 7, 0}) EXPECT_EQ(bits_of(cleaned(threads)), one) << threads << " threads";
}

TEST(MeshThreads, FewerThanNoneAreRefused) {
  const Arrays a = shapes::cube(1);
  EXPECT_THROW(clean(a.vertices, a.triangles, {.threads = -1}, job()), InvalidInput);
}

TEST(MeshThreads, TheFirstDefectIsNamedOnAnyNumberOfThem) {
  const auto message = [](const Arrays& a, std::int32_t threads) {
    return message_of([&] { static_cast<void>(Mesh(a.vertices, a.triangles, job(), threads)); });
  };
  const std::vector<std::function<void(Arrays&)>> defects{
      [](Arrays& a) { a.vertices[40'000].x() = a.vertices[50'000].x() = std::numeric_limits<double>::infinity(); },
      [](Arrays& a) { a.triangles[70'000][1] = a.triangles[120'000][1] = 1 << 30; },
      [](Arrays& a) { a.triangles[80'000][0] = a.triangles[80'000][1]; },
      [](Arrays& a) { a.triangles[100'000] = a.triangles[120'000] = a.triangles[20]; },  // three faces an edge
      [](Arrays& a) { std::swap(a.triangles[110'000][0], a.triangles[110'000][1]); },    // the same way along edges
      [](Arrays& a) {
        for (Triangle& t : a.triangles)
          for (auto& v : t)
            if (v == 9) v = 30'000;
      },  // two fans
  };
  for (std::size_t i = 0; i < defects.size(); ++i) {
    Arrays a = many_parts();
    defects[i](a);
    const std::string one = message(a, 1);
    EXPECT_NE(one, "no error") << "defect " << i;
    for (const std::int32_t threads : {2, 5}) EXPECT_EQ(message(a, threads), one) << "defect " << i;
  }
}

}  // namespace
}  // namespace isimp
