// Planes at nearly equal distances, as storeys, stairs and windows have them.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "even_spacing.h"

namespace {

using isimp::regular::even_spacing;
using isimp::regular::EvenSpacing;
using isimp::regular::ParallelPlane;

constexpr double kTolerance = 0.01;

ParallelPlane at(double offset, bool faces_along = true) {
  return {offset, offset - 2 * kTolerance, offset + 2 * kTolerance, 1.0, faces_along, false};
}

std::vector<ParallelPlane> planes_at(const std::vector<double>& offsets) {
  std::vector<ParallelPlane> planes;
  for (const double offset : offsets) planes.push_back(at(offset));
  return planes;
}

/// The deviation of the distances of adjacent planes from equal ones.
double unevenness(const std::vector<double>& offset) {
  double most = 0;
  for (std::size_t i = 2; i < offset.size(); ++i)
    most = std::max(most, std::abs(offset[i] - 2 * offset[i - 1] + offset[i - 2]));
  return most;
}

TEST(EvenSpacing, StepsOfAStairBecomeEqual) {
  const std::vector<double> treads = {0.003, 0.172, 0.352, 0.521, 0.704, 0.872};
  const EvenSpacing found = even_spacing(planes_at(treads), kTolerance);
  EXPECT_EQ(found.series, 1);
  EXPECT_EQ(found.planes, 6);
  EXPECT_LT(unevenness(found.offset), 1e-12);
  for (std::size_t i = 0; i < treads.size(); ++i) EXPECT_NEAR(found.offset[i], treads[i], kTolerance);
}

TEST(EvenSpacing, OneTreadMayBeMissingAndOtherPlanesStay) {
  const EvenSpacing found = even_spacing(planes_at({0.0, 0.302, 0.898, 1.2, 1.501, 0.731}), kTolerance);
  EXPECT_EQ(found.planes, 5);
  EXPECT_EQ(found.offset[5], 0.731);
  const double step = found.offset[1] - found.offset[0];
  EXPECT_NEAR(found.offset[2] - found.offset[1], 2 * step, 1e-12);
  EXPECT_NEAR(found.offset[4] - found.offset[3], step, 1e-12);
}

TEST(EvenSpacing, ChanceIsNoSeries) {
  std::mt19937 random(7);
  int planes = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> offsets;
    for (int i = 0; i < 8; ++i) offsets.push_back(random() * 0x1p-32);
    planes += even_spacing(planes_at(offsets), 0.003).planes;
  }
  EXPECT_LT(planes, 40);  // there were 400; a series has at least three
}

TEST(EvenSpacing, AFixedPlaneStaysAndTheOthersFollow) {
  std::vector<ParallelPlane> planes = planes_at({0.006, 0.3, 0.6, 0.9, 1.2});
  planes[0].is_fixed = true;
  planes[0].low = planes[0].high = planes[0].offset;
  const EvenSpacing found = even_spacing(planes, kTolerance);
  EXPECT_EQ(found.offset[0], 0.006);
  EXPECT_LT(unevenness(found.offset), 1e-9);
}

TEST(EvenSpacing, NoPlaneMovesFurtherThanItMay) {
  std::vector<ParallelPlane> planes = planes_at({0.0, 0.308, 0.6, 0.9, 1.2, 1.5});
  planes[1].low = 0.3055;
  const EvenSpacing found = even_spacing(planes, kTolerance);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    EXPECT_GE(found.offset[i], planes[i].low - 1e-6);
    EXPECT_LE(found.offset[i], planes[i].high + 1e-6);
  }
}

TEST(EvenSpacing, SillsAndLintelsShareTheirStep) {
  std::vector<ParallelPlane> planes;
  for (int storey = 0; storey < 5; ++storey) {
    planes.push_back(at(3.0 * storey + (storey % 2 == 0 ? 0.004 : -0.004)));          // sill
    planes.push_back(at(3.001 * storey + 1.4 + (storey == 2 ? 0.006 : 0.0), false));  // lintel
  }
  const EvenSpacing found = even_spacing(planes, kTolerance);
  EXPECT_EQ(found.series, 2);
  for (int storey = 1; storey < 5; ++storey)
    EXPECT_NEAR(found.offset[2 * storey + 1] - found.offset[2 * storey], found.offset[1] - found.offset[0], 1e-12);
}

TEST(EvenSpacing, WindowsAtAnyPlaceGetOneWidth) {
  std::vector<ParallelPlane> planes;
  const double left[] = {0.31, 2.0, 4.57, 5.93, 9.02}, width[] = {0.902, 0.896, 0.9, 0.907, 0.898};
  for (int k = 0; k < 5; ++k) {
    planes.push_back(at(left[k]));
    planes.push_back(at(left[k] + width[k], false));
  }
  const EvenSpacing found = even_spacing(planes, kTolerance);
  EXPECT_EQ(found.sizes, 1);
  for (int k = 1; k < 5; ++k)
    EXPECT_NEAR(found.offset[2 * k + 1] - found.offset[2 * k], found.offset[1] - found.offset[0], 1e-12);
}

TEST(EvenSpacing, FewPlanesStay) {
  EXPECT_EQ(even_spacing({}, kTolerance).planes, 0);
  EXPECT_EQ(even_spacing(planes_at({1.0, 2.0}), kTolerance).planes, 0);
}

}  // namespace
