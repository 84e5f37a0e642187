#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isimp::meshing::planar {

/// A symmetric positive definite system of blocks of three unknowns, solved by a sparse LDL' decomposition. The
/// analysis of the pattern is done once.
/// Source: Davis 2005, Algorithm 849, with blocks in the place of numbers.
class BlockSystem {
 public:
  using Mat3 = Eigen::Matrix3d;
  using Vec3 = Eigen::Vector3d;

  BlockSystem() = default;
  /// \param pairs  {row, column}, row > column, of blocks that may not be zero; each may be named several times
  BlockSystem(std::int32_t count, std::span<const std::array<std::int32_t, 2>> pairs);

  /// Sets all blocks to zero.
  void clear();
  /// The block on the diagonal.
  [[nodiscard]] Mat3& diagonal(std::int32_t k) { return diagonal_[place_[k]]; }
  /// Adds to the block of a pair, by its number in the list.
  void add(std::size_t pair, const Mat3& block) {
    const Slot& e = entry_[pair];
    if (e.transposed) {
      block_[e.slot].noalias() += block.transpose();
    } else {
      block_[e.slot] += block;
    }
  }
  /// \return the unknowns; zero where there is no finite answer
  [[nodiscard]] const std::vector<Vec3>& solve(std::span<const Vec3> right);

 private:
  struct Slot {
    std::int32_t slot;
    bool transposed;
  };
  void analyse();
  void factorise();
  /// Writes the columns in which row k of the factor is not zero into `reach_`, from `top` on, in an order in which
  /// they can be eliminated.
  /// \return top
  std::int32_t reach(std::int32_t k);

  std::int32_t count_ = 0;
  std::vector<std::int32_t> place_;  // by unknown: its place in the elimination
  std::vector<Slot> entry_;          // by pair
  // The blocks above the diagonal, by column, in the order of elimination: the upper half, as rows of the factor are
  // found from it.
  std::vector<std::int32_t> start_, row_;
  std::vector<Mat3> block_, diagonal_;
  std::vector<std::int32_t> parent_, factor_start_, fill_, factor_row_;  // the factor, by column
  std::vector<Mat3> factor_, inverse_, work_;                            // inverse_: inverse of the factor's diagonal
  std::vector<std::int32_t> reach_, path_, mark_;
  std::vector<Vec3> unknown_, answer_;
};

}  // namespace isimp::meshing::planar
