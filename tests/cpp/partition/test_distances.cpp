// The metric of normals and distances: its sums, its moves, and the regions that go by it.

#include "borders/distances.h"
#include "borders/relax.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/symmetric.h"
#include "isimp/partition/regions.h"
#include "methods.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr int kRegions = 64;

/// A bumpy torus, and regions that are cut without regard to its bumps: a quarter of the tube each.
struct Bumpy {
  Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(96, 48), 0.01, 5));
  const FaceGraph& graph = mesh.graph();
  Regions regions{std::vector<std::int32_t>(graph.faces.size(), kNone), std::vector<RegionSum>(kRegions)};

  Bumpy() {
    const auto part = [](double y, double x, int parts) {
      return std::min(parts - 1, static_cast<int>(parts * (std::atan2(y, x) / (2 * std::numbers::pi) + 0.5)));
    };
    for (std::int32_t i = 0; i < graph.size(); ++i) {
      const Vec3& p = mesh.vertices()[mesh.triangles()[graph.mesh_face[i]][0]];
      regions.label[i] = 4 * part(p.y(), p.x(), kRegions / 4) + part(p.z(), std::hypot(p.x(), p.y()) - 1, 4);
    }
    sum_regions(graph, regions, job());
  }
  [[nodiscard]] GraphLabels labels() { return {regions.label.data()}; }
};

/// Sum of area * d^2 / (.06 side)^2 over the regions, from their planes of least squares; areas as shares of the whole.
double from_planes(const Mesh& mesh, const std::vector<std::int32_t>& label, int regions) {
  double sum = 0;
  for (int r = 0; r < regions; ++r) {
    double area = 0;
    Vec3 first = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (std::int32_t i = 0; i < mesh.graph().size(); ++i) {
      if (label[i] != r) continue;
      for (const std::int32_t v : mesh.triangles()[mesh.graph().mesh_face[i]]) {
        const double w = mesh.graph().faces[i].area / 3.0;
        const Vec3& p = mesh.vertices()[v];
        area += w;
        first += w * p;
        second += w * p * p.transpose();
      }
    }
    second -= first * first.transpose() / area;
    sum += spectrum_of(second).values[0];
  }
  return sum * regions / (mesh.graph().area * 0.06 * 0.06);
}

TEST(Distances, SumUpToTheErrorOfThePlanesOfLeastSquares) {
  Bumpy bumpy;
  Distances distances(bumpy.mesh, Metric::mixed, kRegions);
  distances.sum_up(bumpy.labels(), bumpy.regions.sum, job());
  for (int k = 0; k < 20; ++k)
    for (int r = 0; r < kRegions; ++r) distances.fit(r);
  EXPECT_NEAR(distances.error() / from_planes(bumpy.mesh, bumpy.regions.label, kRegions), 1, 1e-9);
}

TEST(Distances, AMoveChangesTheErrorByWhatTheFaceCostsAndAFitLowersIt) {
  Bumpy bumpy;
  Distances distances(bumpy.mesh, Metric::mixed, kRegions);
  distances.sum_up(bumpy.labels(), bumpy.regions.sum, job());
  int moved = 0;
  for (std::int32_t i = 0; i < bumpy.graph.size(); ++i) {
    const std::int32_t from = bumpy.regions.label[i];
    for (const std::int32_t j : bumpy.graph.neighbours[i]) {
      const std::int32_t to = bumpy.regions.label[j];
      if (to < 0 || to == from) continue;
      const auto corners = distances.corners(i);
      const double before = distances.error(), area = bumpy.graph.faces[i].area;
      const double change = area * (distances.square(corners, to) - distances.square(corners, from));
      distances.move(i, from, to);
      const double after = distances.error();
      EXPECT_NEAR(after - before, change, 1e-12 * before);
      distances.fit(from);
      distances.fit(to);
      EXPECT_LE(distances.error(), after * (1 + 1e-12));
      bumpy.regions.label[i] = to;
      ++moved;
      break;
    }
  }
  EXPECT_GT(moved, 100);
  const double error = distances.error();
  sum_regions(bumpy.graph, bumpy.regions, job());
  distances.sum_up(bumpy.labels(), bumpy.regions.sum, job());
  for (int k = 0; k < 20; ++k)
    for (int r = 0; r < kRegions; ++r) distances.fit(r);
  EXPECT_NEAR(distances.error() / error, 1, 1e-3) << "a few steps of each fit are enough";
}

TEST(Distances, AreZeroOnFlatRegions) {
  const Mesh mesh = shapes::mesh(shapes::cube(6));
  Regions regions{std::vector<std::int32_t>(mesh.graph().faces.size(), kNone), std::vector<RegionSum>(6)};
  for (std::int32_t i = 0; i < mesh.graph().size(); ++i) regions.label[i] = mesh.graph().mesh_face[i] / 72;
  sum_regions(mesh.graph(), regions, job());
  Distances distances(mesh, Metric::mixed, 6);
  distances.sum_up(GraphLabels{regions.label.data()}, regions.sum, job());
  EXPECT_LT(distances.error(), 1e-20);
}

TEST(Distances, RelaxingLowersTheErrorByItsMetric) {
  for (const Metric metric : {Metric::mixed, Metric::distance}) {
    Bumpy bumpy;
    Relaxation<GraphLabels> relaxation(bumpy.graph, bumpy.labels(), bumpy.regions.sum, {});
    for (std::int32_t i = 0; i < bumpy.graph.size(); ++i) relaxation.push_if_border(i);
    Distances distances(bumpy.mesh, metric, kRegions);
    distances.sum_up(bumpy.labels(), bumpy.regions.sum, job());
    const double before = error_by(distances, bumpy.regions.sum);
    relaxation.measure(&distances);
    EXPECT_GT(relaxation.run(100, job()), 100);
    EXPECT_LT(error_by(distances, bumpy.regions.sum), 0.9 * before);
  }
}

std::vector<std::int32_t> labels_of(const Mesh& mesh, Metric metric, std::int32_t threads = 1) {
  const PartitionOptions options{.proxies = 60, .metric = metric, .threads = threads};
  return by_number(mesh, build_hierarchy(mesh, 60, job(), {.threads = threads}), options, job()).face_region;
}

TEST(Distances, OfRegionsThatASweepComesToAreThoseOfAll) {
  const auto relaxed = [](bool all) {
    Bumpy bumpy;  // with connected regions, since a sweep walks over those that it comes to
    const auto label = labels_of(bumpy.mesh, Metric::normals);
    for (std::int32_t i = 0; i < bumpy.graph.size(); ++i) bumpy.regions.label[i] = label[bumpy.graph.mesh_face[i]];
    sum_regions(bumpy.graph, bumpy.regions, job());
    Relaxation<GraphLabels> relaxation(bumpy.graph, bumpy.labels(), bumpy.regions.sum, {});
    for (std::int32_t i = 0; i < bumpy.graph.size(); ++i)
      if (bumpy.regions.label[i] == 0) relaxation.push_if_border(i);
    Distances distances(bumpy.mesh, Metric::mixed, kRegions);
    if (all)
      distances.sum_up(bumpy.labels(), bumpy.regions.sum, job());
    else
      distances.forget(kRegions);
    relaxation.measure(&distances);
    EXPECT_GT(relaxation.run(1, job()), 0);
    EXPECT_EQ(distances.knows_all(), all);
    return bumpy.regions.label;
  };
  EXPECT_EQ(relaxed(true), relaxed(false));
}

TEST(Distances, OfAMeshOfTwiceTheSizeAreTheSameBits) {
  const shapes::Arrays arrays = shapes::noisy(shapes::torus(90, 45), 0.003, 2);
  for (const Metric metric : {Metric::mixed, Metric::distance}) {
    const auto one = labels_of(shapes::mesh(arrays), metric);
    EXPECT_NE(one, labels_of(shapes::mesh(arrays), Metric::normals));
    for (const int power : {-40, 1, 40})
      EXPECT_EQ(one, labels_of(shapes::mesh(shapes::scaled(arrays, std::ldexp(1.0, power))), metric)) << power;
  }
}

TEST(Distances, ThreadsChangeNoLabel) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(500, 250), 0.001, 4));
  EXPECT_EQ(labels_of(mesh, Metric::mixed, 1), labels_of(mesh, Metric::mixed, 3));
}

}  // namespace
}  // namespace isimp
