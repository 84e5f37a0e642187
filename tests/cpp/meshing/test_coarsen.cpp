// Unneeded charts of a split region join their neighbours, also those of other regions.
#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "tests.h"

namespace isimp {
namespace {

/// A noisy square: a disc in the middle, and a ring around it that has to be cut. The rest is a third region.
class Coarsen : public testing::Test {
 protected:
  [[nodiscard]] MeshingReport report_of(const Partition& part) const {
    return polygonize(mesh_, part, {.threads = 1}, job()).report;
  }
  /// \param outer  of the ring, its radius
  [[nodiscard]] std::vector<std::int32_t> labels(double outer) const {
    return shapes::labels(mesh_, [&](const Vec3& middle) {
      const double r = std::hypot(middle.x() - 0.5, middle.y() - 0.5);
      return r < 0.3 ? 0 : r < outer ? 1 : 2;
    });
  }

  const Mesh mesh_ = shapes::mesh(shapes::noisy(shapes::plane(40), 0.001, 3));
};

TEST_F(Coarsen, HalfARingGoesToTheDiscInIt) {
  const MeshingReport r = report_of(labelled::by(labels(0.4)));
  EXPECT_EQ(r.regions, 3);
  EXPECT_TRUE(r.imperfect.empty());
  EXPECT_LT(r.polygons, 5);  // two halves of the ring, two of the rest, the disc
}

TEST_F(Coarsen, NothingGoesToALockedRegion) {
  Partition part = labelled::by(labels(0.4));
  part.region_locked = {1, 1, 1};
  EXPECT_EQ(report_of(part).polygons, 5);
}

TEST_F(Coarsen, WhatARegionHadApartStaysInIt) {
  std::vector<std::int32_t> label = labels(0.3);
  for (std::int32_t& l : label) l = l == 2 ? 1 : 0;
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f) {
    const Vec3& v = mesh_.vertices()[mesh_.triangles()[f][0]];
    if (std::abs(v.x() - 0.5) > 0.38 && std::abs(v.y() - 0.5) > 0.38) label[f] = 0;  // the corners of the square
  }
  const MeshingReport r = report_of(labelled::by(label));
  EXPECT_GE(r.split_for_unconnected, 3);  // half of the other region can join the disc, and one with it
  EXPECT_LE(r.polygons, 7);
}

// With many splits, charts of mixed regions appear and disappear; a region must not lose its last one.
TEST(CoarsenRough, EveryRegionKeepsAPolygon) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(5), 0.06, 7));
  const MeshingReport r = polygonize(mesh, labelled::voronoi(mesh, 30, 7), {.threads = 1}, job()).report;
  EXPECT_GT(r.polygons, 100);
  EXPECT_EQ(r.regions, 30);
}

}  // namespace
}  // namespace isimp
