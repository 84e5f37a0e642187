#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace isimp {

/// Solves a symmetric positive semi-definite system whose unknowns have different units, such as turns and lengths.
/// Rows and columns are scaled to a diagonal of 1 first. So the order of elimination, and with it every bit of the
/// result, does not depend on the unit of length.
/// \param matrix  (N, N)
/// \param right   (N, K)
/// Cost: O(N^3 + K N^2).
template <class Matrix, class Right>
Right solve_balanced(const Matrix& matrix, const Right& right) {
  using Column = Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>;
  const Column scale = matrix.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  const Matrix balanced = scale.asDiagonal() * matrix * scale.asDiagonal();
  return scale.asDiagonal() * balanced.ldlt().solve(scale.asDiagonal() * right);
}

}  // namespace isimp
