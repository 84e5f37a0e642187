// Tests of the timer's own parts.
#include <gtest/gtest.h>

#include <numeric>
#include <sstream>

#include "evaluate.h"
#include "flooding.h"
#include "input.h"
#include "isimp/core/errors.h"
#include "isimp/simplify/partitioner.h"
#include "measure.h"
#include "reference.h"
#include "shapes.h"

namespace isimp::bench {
namespace {

/// Labels of shapes::cube(n), whose faces are ordered by side.
std::vector<std::int32_t> sides(const Mesh& mesh) {
  std::vector<std::int32_t> label(static_cast<std::size_t>(mesh.face_count()));
  for (std::size_t f = 0; f < label.size(); ++f) label[f] = static_cast<std::int32_t>(6 * f / label.size());
  return label;
}

Mesh mesh_of(const Arrays& arrays) {
  Job job;
  return {arrays.vertices, arrays.triangles, job};
}

TEST(Evaluate, CubeBySidesHasNoErrorAndTwelveBorders) {
  const Mesh mesh = shapes::mesh(shapes::cube(3));
  const Score score = evaluate(mesh, plain_surface(mesh), sides(mesh));
  EXPECT_NEAR(score.error, 0.0, 1e-12);
  EXPECT_EQ(score.border_edges, 12 * 3);
  EXPECT_NEAR(score.border_length, 12.0, 1e-9);
  EXPECT_EQ(score.regions, 6);
  EXPECT_EQ(score.fragments, 0);
  EXPECT_EQ(score.unlabelled, 0);
}

TEST(Evaluate, TwoSidesAsOneRegionCostByTheirAngle) {
  const Mesh mesh = shapes::mesh(shapes::cube(2));
  std::vector<std::int32_t> label = sides(mesh);
  for (std::int32_t& l : label)
    if (l == 3) l = 0;  // z = 0 and x = 0: a right angle
  const Score score = evaluate(mesh, plain_surface(mesh), label);
  EXPECT_NEAR(score.error, (2 - std::sqrt(2.0)) / 3, 1e-6);  // 2 (A - |S|) with A = 2/6, |S| = sqrt(2)/6
  EXPECT_EQ(score.regions, 5);
}

TEST(Evaluate, CountsFragmentsAndFacesWithoutRegion) {
  const Mesh mesh = shapes::mesh(shapes::cube(1));
  std::vector<std::int32_t> label = sides(mesh);
  label[2] = label[3] = 0;  // the opposite side, z = 1
  label[4] = kNone;
  const Score score = evaluate(mesh, plain_surface(mesh), label);
  EXPECT_EQ(score.fragments, 1);
  EXPECT_EQ(score.unlabelled, 1);
  EXPECT_NEAR(score.unlabelled_area, 1.0 / 12, 1e-6);
}

TEST(Reference, OneRegionOfAClosedSurfaceHasErrorTwo) {
  const Mesh mesh = shapes::mesh(shapes::cube(2));
  const ReferenceResult result = reference(plain_surface(mesh), {.proxies = 1, .rounds = 3});
  EXPECT_EQ(result.history.size(), 3U);
  EXPECT_NEAR(result.history.back(), 2.0, 1e-6);  // the normals cancel: 2 (A - 0)
}

TEST(Reference, EachFaceItsOwnRegionHasNoError) {
  const Mesh mesh = shapes::mesh(shapes::cube(1));
  const ReferenceResult result = reference(plain_surface(mesh), {.proxies = 12, .rounds = 2});
  EXPECT_NEAR(result.history.back(), 0.0, 1e-12);
  EXPECT_EQ(evaluate(mesh, plain_surface(mesh), result.label).regions, 12);
}

TEST(Reference, RegionsAreConnectedAndTheErrorFitsTheLabels) {
  const Mesh mesh = mesh_of(load_input("made:torus:4000", 0));
  const PlainSurface surface = plain_surface(mesh);
  const ReferenceResult result = reference(surface, {.proxies = 40, .seed = 3});
  const Score score = evaluate(mesh, surface, result.label);
  EXPECT_EQ(score.regions, 40);
  EXPECT_EQ(score.fragments, 0);
  EXPECT_EQ(score.unlabelled, 0);
  EXPECT_NEAR(score.error, result.history.back(), 1e-6);  // unit only up to the rounding of a float
  EXPECT_LT(score.error, result.history.front());
  EXPECT_EQ(reference(surface, {.proxies = 40, .seed = 3}).label, result.label);
}

TEST(Reference, ComponentsWithoutASeedStayWithoutRegion) {
  const Mesh mesh = mesh_of(load_input("made:boxes:24", 0));
  const ReferenceResult result = reference(plain_surface(mesh), {.proxies = 1});
  EXPECT_EQ(std::count(result.label.begin(), result.label.end(), kNone), 12);
}

/// Floods once from the seeds that the reference would start from.
std::vector<std::int32_t> flooded_by_bursts(const Mesh& mesh, std::int32_t proxies, std::uint32_t seed) {
  const FaceGraph& graph = mesh.graph();
  std::vector<std::int32_t> seeds = random_faces(mesh.face_count(), proxies, seed), label(graph.faces.size());
  std::vector<NormalMetric::Proxy> normals;
  for (std::int32_t& face : seeds) {
    face = graph.graph_face[face];
    normals.push_back(NormalMetric::proxy_of(graph.faces[face]));
  }
  Job job;
  Flooding().run(graph, normals, seeds, label, job);
  std::vector<std::int32_t> by_mesh_face(static_cast<std::size_t>(graph.size()));
  for (std::size_t f = 0; f < by_mesh_face.size(); ++f) by_mesh_face[f] = label[graph.graph_face[f]];
  return by_mesh_face;
}

TEST(Flooding, ByBurstsIsAsGoodAsByOneQueue) {
  const Mesh mesh = mesh_of(load_input("made:torus:20000", 0));
  const PlainSurface surface = plain_surface(mesh);
  double plain = 0.0, bursts = 0.0;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const auto one = reference(surface, {.proxies = 60, .rounds = 1, .seed = seed}).label;
    const auto other = flooded_by_bursts(mesh, 60, seed);
    const Score score = evaluate(mesh, surface, other);
    EXPECT_EQ(score.regions, 60);
    EXPECT_EQ(score.fragments, 0);
    EXPECT_EQ(score.unlabelled, 0);
    plain += evaluate(mesh, surface, one).error;
    bursts += score.error;
    std::size_t equal = 0;
    for (std::size_t f = 0; f < one.size(); ++f) equal += one[f] == other[f];
    EXPECT_GT(equal, 8 * one.size() / 10);  // the same seeds, so nearly the same regions
  }
  EXPECT_NEAR(bursts / plain, 1.0, 0.01);
}

TEST(Lloyd, IsAsGoodAsTheReference) {
  const Mesh mesh = mesh_of(load_input("made:torus:6000", 0));
  const PlainSurface surface = plain_surface(mesh);
  double plain = 0.0, own = 0.0;
  for (std::uint32_t seed = 1; seed <= 16; ++seed) {
    plain += evaluate(mesh, surface, reference(surface, {.proxies = 50, .seed = seed}).label).error;
    Job job;
    const PartitionOptions options{.proxies = 50, .seed = seed, .method = Method::lloyd};
    own += evaluate(mesh, surface, partition(mesh, options, job).face_region).error;
  }
  EXPECT_LT(own, 1.02 * plain);  // other random seeds, so equal only on the mean
}

TEST(Loop, FlatRegularGridStaysWhereItIs) {
  const Arrays coarse = load_input("made:plane:50", 0);  // 5 by 5 squares of side 1
  const Arrays fine = subdivided(coarse);
  EXPECT_EQ(fine.triangles.size(), 4 * coarse.triangles.size());
  const std::size_t inner = 2 * 6 + 3;  // at (2, 3), with six faces
  EXPECT_NEAR((fine.vertices[inner] - Vec3(2, 3, 0)).norm(), 0.0, 1e-12);
  const Mesh mesh = mesh_of(fine);
  EXPECT_EQ(mesh.report().border_edges, 40);
  const Vec3 corner = fine.vertices[0];  // on the border's B-spline: 3/4 (0, 0) + 1/8 (1, 0) + 1/8 (0, 1)
  EXPECT_NEAR((corner - Vec3(0.125, 0.125, 0)).norm(), 0.0, 1e-12);
}

TEST(Loop, ClosedSurfaceStaysClosedAndShrinks) {
  const auto cube = shapes::cube(1);
  const Mesh mesh = mesh_of(subdivided({cube.vertices, cube.triangles}));
  EXPECT_EQ(mesh.face_count(), 48);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.report().euler, 2);
  EXPECT_LT(mesh.report().area, 6.0);
}

struct Kind {
  const char* name;
  std::int32_t faces, components, border_loops;
  std::int64_t euler;
};

class Made : public testing::TestWithParam<Kind> {};

TEST_P(Made, IsASoundMeshOfAboutTheRequestedSize) {
  const Kind kind = GetParam();
  const Mesh mesh = mesh_of(load_input(kind.name, 0));
  EXPECT_NEAR(mesh.face_count(), kind.faces, 0.05 * kind.faces);
  EXPECT_EQ(mesh.component_count(), kind.components);
  EXPECT_EQ(mesh.report().border_loops, kind.border_loops);
  EXPECT_EQ(mesh.report().euler, kind.euler);
  EXPECT_EQ(mesh.report().zero_area_faces, 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Made,
                         testing::Values(Kind{"made:torus:20000", 20000, 1, 0, 0},
                                         Kind{"made:slivers:20000", 20000, 1, 0, 0},
                                         Kind{"made:plane:20000", 20000, 1, 1, 1},
                                         Kind{"made:boxes:1200", 1200, 100, 0, 200},
                                         Kind{"made:perforated:16000", 16320, 1, 0, -198}),
                         [](const auto& test) { return "of" + std::to_string(test.index); });

TEST(Input, NamesTheFault) {
  EXPECT_THROW(load_input("made:torus", 0), InvalidInput);
  EXPECT_THROW(load_input("made:teapot:100", 0), InvalidInput);
  EXPECT_THROW(load_input("no/such/file.ply", 0), InvalidInput);
}

TEST(Json, PrintsEveryKindOfValue) {
  Json json;
  json["text"] = "a \"quoted\" word";
  json["list"] = std::vector<double>{1, 2.5, std::numeric_limits<double>::infinity()};
  json["truth"] = true;
  std::ostringstream out;
  out << json;
  EXPECT_EQ(out.str(), "{\"list\": [1, 2.5, null],\n\"text\": \"a \\\"quoted\\\" word\",\n\"truth\": true}");
}

TEST(MemoryGauge, MeasuresUsedAndFreedMemory) {
  if (peak_memory() == 0) GTEST_SKIP() << "this system does not tell its peak memory";
  constexpr std::size_t kBytes = 64U << 20;
  const MemoryGauge gauge;
  { std::vector<char> block(kBytes, 1); }
  EXPECT_GE(gauge.peak(), static_cast<std::int64_t>(kBytes) * 9 / 10);  // the kernel counts in batches of pages
  EXPECT_LT(gauge.peak(), static_cast<std::int64_t>(2 * kBytes));
}

}  // namespace
}  // namespace isimp::bench
