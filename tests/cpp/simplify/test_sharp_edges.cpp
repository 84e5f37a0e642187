// Strips along an edge join the planes that meet there.
#include "isimp/mesh/mesh.h"
#include "labelled.h"
#include "sharp_edges.h"
#include "tests.h"

namespace isimp {
namespace {

constexpr int kAlong = 40;

/// A bent sheet: `widths` of its bands of faces, and by how many degrees each is turned. A region a band.
std::pair<Mesh, Partition> bent(const std::vector<double>& widths, const std::vector<double>& degrees) {
  std::vector<Vec3> profile{Vec3::Zero()};
  std::vector<std::int32_t> band;  // by step of the profile
  for (std::size_t k = 0; k < widths.size(); ++k) {
    const double angle = degrees[k] * std::numbers::pi / 180;
    const int steps = std::max(1, static_cast<int>(std::lround(widths[k])));
    for (int i = 0; i < steps; ++i) {
      profile.push_back(profile.back() + widths[k] / steps * Vec3(std::cos(angle), 0, std::sin(angle)));
      band.push_back(static_cast<std::int32_t>(k));
    }
  }
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> region;
  for (const Vec3& p : profile)
    for (int j = 0; j <= kAlong; ++j) vertices.push_back(p + Vec3(0, j, 0));
  for (std::size_t i = 0; i < band.size(); ++i)
    for (int j = 0; j < kAlong; ++j) {
      const int a = static_cast<int>(i) * (kAlong + 1) + j;
      triangles.push_back({a, a + kAlong + 1, a + kAlong + 2});
      triangles.push_back({a, a + kAlong + 2, a + 1});
      region.insert(region.end(), 2, band[i]);
    }
  Mesh mesh(std::move(vertices), std::move(triangles), job());
  return {std::move(mesh), labelled::by(std::move(region))};
}

std::size_t regions_left(const std::vector<double>& widths, const std::vector<double>& degrees,
                         std::int32_t least = 1) {
  const auto [mesh, partition] = bent(widths, degrees);
  const auto labels = without_strips(mesh, partition, 3, least, job());
  const std::vector<std::int32_t>& found = labels ? *labels : partition.face_region;
  return std::set<std::int32_t>(found.begin(), found.end()).size();
}

TEST(SharpEdges, AStripJoinsThePlanesOnItsSides) { EXPECT_EQ(regions_left({20, 1.2, 20}, {0, 45, 90}), 2U); }

TEST(SharpEdges, AsManyRegionsAreLeftAsAreNeeded) {
  const std::vector<double> widths{20, 1.2, 20, 1.4, 20}, degrees{0, 45, 90, 135, 180};
  for (const std::int32_t least : {1, 3, 4, 5, 6})
    EXPECT_EQ(regions_left(widths, degrees, least), std::clamp(least, 3, 5)) << least;
}

TEST(SharpEdges, TwoStripsAlongOneEdgeJoinThem) {
  EXPECT_EQ(regions_left({20, 1, 1, 20}, {0, 30, 60, 90}), 2U);
  EXPECT_EQ(regions_left({20, 1.2, 1, 20}, {0, 28, 62, 90}), 2U);
}

TEST(SharpEdges, WiderBandsStay) {
  EXPECT_EQ(regions_left({20, 3, 20}, {0, 45, 90}), 3U);
  EXPECT_EQ(regions_left({20, 3, 3, 20}, {0, 30, 60, 90}), 4U);
}

TEST(SharpEdges, AStepStays) { EXPECT_EQ(regions_left({20, 1, 20}, {0, 60, 0}), 3U); }

}  // namespace
}  // namespace isimp
