// Borders between regions as lengths: their length, their weight, and the straightening by relaxing.

#include "borders/relax.h"
#include "hierarchy/region_graph.h"
#include "isimp/partition/regions.h"
#include "tests.h"

namespace isimp {
namespace {

TEST(BorderLengths, AreThoseOfTheMeshOnAnyThreads) {
  // The unit square cut at a quarter and at half of its height.
  const Mesh mesh = shapes::mesh(shapes::plane(8));
  const FaceGraph& graph = mesh.graph();
  std::vector<std::int32_t> label(graph.faces.size(), kNone), faces;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const double y = shapes::middle(mesh, graph.mesh_face[i]).y();
    label[i] = y < 0.25 ? 0 : y < 0.5 ? 1 : 2;
    faces.push_back(i);
  }
  const MergeGraph touching = graph_of_regions(graph, label, 3, {}, faces);
  for (const int threads : {1, 3}) {
    const std::vector<double> lengths = border_lengths(mesh, label, faces, touching, Threads(threads));
    ASSERT_EQ(lengths.size(), 4U);
    for (const double length : lengths) EXPECT_NEAR(length, 1.0, 1e-9);
  }
}

TEST(Relaxation, WideBordersBecomeStraight) {
  // A flat square in two halves whose border oscillates by three rows: counted over all faces that share a vertex
  // nothing but the straight line is short.
  const Mesh mesh = shapes::mesh(shapes::plane(24));
  const FaceGraph& graph = mesh.graph();
  Regions r{std::vector<std::int32_t>(graph.faces.size(), kNone), std::vector<RegionSum>(2)};
  std::vector<std::int32_t> faces;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const Vec3 c = shapes::middle(mesh, graph.mesh_face[i]);
    r.label[i] = c.y() < 0.5 + 0.06 * std::sin(30 * c.x()) ? 0 : 1;
    faces.push_back(i);
  }
  sum_regions(graph, r, job());
  const auto length = [&] {
    return border_lengths(mesh, r.label, faces, graph_of_regions(graph, r.label, 2, {}, faces), Threads(1))[0];
  };
  EXPECT_GT(length(), 1.4);
  const Regions start = r;
  const auto relax = [&](BorderWeight weight) {
    r = start;
    Relaxation<GraphLabels> relaxation(graph, {r.label.data()}, r.sum, weight);
    for (const std::int32_t i : faces) relaxation.push_if_border(i);
    relaxation.run(200, job());
    return length();
  };
  const double edges_alone = relax(border_weight(0.05)), wide = relax(border_weight(0.05, 1.0, graph.size(), 2));
  EXPECT_LT(wide, 1.25);
  EXPECT_LT(wide, 0.95 * edges_alone);
}

TEST(BorderWeight, IsForALengthAtAnyResolution) {
  // Four times the faces: edges are half as long, so that a border has twice as many.
  const BorderWeight coarse = border_weight(0.04, 0.5, 10000, 100), fine = border_weight(0.04, 0.5, 40000, 100);
  EXPECT_NEAR(coarse.edge / 10000, 2 * fine.edge / 40000, 1e-12);
  EXPECT_FALSE(border_weight(0.04, 0.0, 10000, 100).is_wide);
  EXPECT_NEAR(border_weight(0.0, 0.5, 10000, 100).edge, 0, 1e-12) << "exact shapes are left alone";
}

}  // namespace
}  // namespace isimp
