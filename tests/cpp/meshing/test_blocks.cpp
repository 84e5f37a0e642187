// The sparse systems of planes that share corners, against dense ones.
#include "isimp/core/symmetric.h"
#include "planar/blocks.h"
#include "tests.h"

namespace isimp::meshing::planar {
namespace {

using Pairs = std::vector<std::array<std::int32_t, 2>>;

/// Neighbours of a grid, each pair named twice, the second time in the opposite order.
Pairs grid(std::int32_t side) {
  Pairs pairs;
  for (std::int32_t y = 0; y < side; ++y)
    for (std::int32_t x = 0; x < side; ++x) {
      const std::int32_t k = y * side + x;
      if (x > 0) pairs.insert(pairs.end(), {{k, k - 1}, {k, k - 1}});
      if (y > 0) pairs.push_back({k, k - side});
    }
  return pairs;
}

/// The largest difference between the answers of a system and of a dense one.
double error(std::int32_t count, const Pairs& pairs, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto block = [&] { return Eigen::Matrix3d(Eigen::Matrix3d::NullaryExpr([&] { return number(random); })); };
  BlockSystem system(count, pairs);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  for (int round = 0; round < 2; ++round) {  // the second time nothing must be left of the first
    system.clear();
    dense.setZero();
    for (std::int32_t k = 0; k < count; ++k) {
      const Eigen::Matrix3d b = block();
      const Eigen::Matrix3d own = b * b.transpose() + 30 * Eigen::Matrix3d::Identity();
      system.diagonal(k) += own;
      dense.block<3, 3>(3 * k, 3 * k) += own;
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const Eigen::Matrix3d b = block();
      const auto [i, j] = pairs[p];
      system.add(p, b);
      dense.block<3, 3>(3 * i, 3 * j) += b;
      dense.block<3, 3>(3 * j, 3 * i) += b.transpose();
    }
  }
  std::vector<Eigen::Vector3d> right(count);
  Eigen::VectorXd all(3 * count);
  for (std::int32_t k = 0; k < count; ++k) all.segment<3>(3 * k) = right[k] = block().col(0);
  const Eigen::VectorXd truth = solve_definite(dense, all);
  double most = 0;
  const auto& found = system.solve(right);
  for (std::int32_t k = 0; k < count; ++k)
    most = std::max(most, (found[k] - truth.segment<3>(3 * k)).cwiseAbs().maxCoeff());
  return most;
}

TEST(BlockSystem, AnswersAreThoseOfADenseSystem) {
  EXPECT_LT(error(1, {}, 1), 1e-13);
  EXPECT_LT(error(5, {{3, 1}, {4, 0}, {2, 1}}, 2), 1e-13);
  EXPECT_LT(error(64, grid(8), 3), 1e-13);
}

TEST(BlockSystem, OfNothingIsNothing) {
  BlockSystem system(0, {});
  EXPECT_TRUE(system.solve({}).empty());
}

TEST(BlockSystem, WithoutAFiniteAnswerItIsZero) {
  BlockSystem system(1, {});
  system.clear();
  system.diagonal(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Eigen::Vector3d> right{Eigen::Vector3d::Ones()};
  EXPECT_EQ(system.solve(right)[0], Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace isimp::meshing::planar
