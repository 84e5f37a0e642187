#include <gtest/gtest.h>

#include "isimp/core/symmetric.h"

namespace isimp {
namespace {

const Eigen::Matrix3d kEven = (Eigen::Matrix3d() << 2, 1, 0, 1, 2, 0, 0, 0, 5).finished();  // 1, 3, 5

TEST(Symmetric, EigenvaluesRiseWithTheirVectorsAsColumns) {
  for (const Spectrum<3>& s : {spectrum_of(kEven), direct_spectrum_of(kEven)}) {
    EXPECT_LT((s.values - Eigen::Vector3d(1, 3, 5)).norm(), 1e-12);
    EXPECT_LT((kEven * s.vectors - s.vectors * s.values.asDiagonal()).norm(), 1e-12);
    EXPECT_LT((s.vectors.transpose() * s.vectors - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
  const Spectrum<2> flat = spectrum_of(Eigen::Matrix2d(kEven.topLeftCorner<2, 2>()));
  EXPECT_LT((flat.values - Eigen::Vector2d(1, 3)).norm(), 1e-12);
}

TEST(Symmetric, SystemsAreSolved) {
  const Eigen::Vector3d x(3, -1, 2);
  EXPECT_LT((solve_definite(kEven, kEven * x) - x).norm(), 1e-12);
  EXPECT_LT((balanced_inverse(kEven) * kEven - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

template <int N>
void expect_solved_as_of_any_size() {
  Eigen::Matrix<double, N, N> m = Eigen::Matrix<double, N, N>::Identity();
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) m(i, j) += 1.0 / (1 + (i + 3 * j) % 5) + 1.0 / (1 + (j + 3 * i) % 5);
  m *= m.transpose().eval();
  const Eigen::Matrix<double, N, 1> b = Eigen::Matrix<double, N, 1>::LinSpaced(1, 2);
  const Eigen::VectorXd x = solve_definite(Eigen::MatrixXd(m), Eigen::VectorXd(b));
  if constexpr (N == 6)
    EXPECT_LT((solve_balanced(m, b) - x).norm(), 1e-9 * x.norm());
  else
    EXPECT_LT((solve_definite(m, b) - x).norm(), 1e-9 * x.norm());
}

TEST(Symmetric, EachFixedSizeIsSolvedAsAnyOther) {
  expect_solved_as_of_any_size<2>();
  expect_solved_as_of_any_size<3>();
  expect_solved_as_of_any_size<4>();
  expect_solved_as_of_any_size<6>();
  EXPECT_EQ(solve_definite(Eigen::Matrix2d(Eigen::Matrix2d::Zero()), Eigen::Vector2d(1, 1)), Eigen::Vector2d(0, 0));
}

TEST(Symmetric, TheUnitOfLengthChangesNoBitOfABalancedSolution) {
  Matrix6 m = Matrix6::Identity();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) m(i, j) += 1.0 / (2 + i + j);
  const Vector6 b = Vector6::LinSpaced(1, 2);
  Vector6 unit;
  unit << 1, 1, 1, 1024, 1024, 1024;  // three turns, three lengths
  const Vector6 scaled = solve_balanced(unit.asDiagonal() * m * unit.asDiagonal(), unit.asDiagonal() * b);
  EXPECT_EQ(unit.asDiagonal() * scaled, solve_balanced(m, b));
}

}  // namespace
}  // namespace isimp
