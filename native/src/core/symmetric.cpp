// One source for the solvers of Eigen: the compiler takes seconds for each of them, and for each size. LDL^T for vectors of
// a fixed size is written out, with the order of sums of Eigen's, so that results have the same bits.
#include "isimp/core/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace isimp {
namespace {

using Terms = std::array<double, 6>;

/// Half of the terms plus the other half, each summed in this way.
double sum_by_halves(const double* terms, int count) {
  const int half = count / 2;
  return count == 1 ? *terms : sum_by_halves(terms, half) + sum_by_halves(terms + half, count - half);
}

/// For at most five terms: of four the pairs first, as vectors of two are summed.
double sum_by_pairs(const Terms& terms, int count) {
  double sum = count < 4 ? terms[0] : (terms[0] + terms[2]) + (terms[1] + terms[3]);
  for (int i = count < 4 ? 1 : 4; i < count; ++i) sum += terms[i];
  return sum;
}

/// Writes the factors L and D of P `a` P^T to the lower triangle of `a`, n x n by columns.
/// Result: the row that row k was swapped with.
std::array<int, 6> factorise(int n, double* a) {
  const auto at = [=](int i, int j) -> double& { return a[i + j * n]; };
  std::array<int, 6> swaps{0, 1, 2, 3, 4, 5};
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(at(i, i)) > std::abs(at(pivot, pivot))) pivot = i;
    if (!(std::abs(at(pivot, pivot)) > 0) && k == 0) break;
    swaps[k] = pivot;
    if (pivot != k) {
      for (int j = 0; j < k; ++j) std::swap(at(k, j), at(pivot, j));
      for (int i = pivot + 1; i < n; ++i) std::swap(at(i, k), at(i, pivot));
      for (int i = k + 1; i < pivot; ++i) std::swap(at(i, k), at(pivot, i));
      std::swap(at(k, k), at(pivot, pivot));
    }
    for (int i = k; i < n && k > 0; ++i) {
      double sum = at(i, 0) * (at(0, 0) * at(k, 0));
      for (int j = 1; j < k; ++j) sum += at(i, j) * (at(j, j) * at(k, j));
      at(i, k) -= sum;
    }
    if (std::abs(at(k, k)) > 0)
      for (int i = k + 1; i < n; ++i) at(i, k) /= at(k, k);
  }
  return swaps;
}

/// The solution in place of the right side `x`. With several of them Eigen subtracts each term by itself, then sums that
/// begin with 0, which is never -0.
void substitute(int n, const double* a, const std::array<int, 6>& swaps, double* x, bool several) {
  Terms terms;
  for (int k = 0; k < n; ++k) std::swap(x[k], x[swaps[k]]);
  for (int i = 1; i < n; ++i) {
    for (int j = 0; j < i; ++j) terms[j] = a[i + j * n] * x[j];
    for (int j = 0; j < i && several; ++j) x[i] -= terms[j];
    if (!several) x[i] -= sum_by_halves(terms.data(), i);
  }
  for (int i = 0; i < n; ++i) {
    const double d = a[i + i * n];
    x[i] = std::abs(d) > std::numeric_limits<double>::min() ? x[i] / d : 0;
  }
  for (int j = n - 2; j >= 0; --j) {
    for (int i = j + 1; i < n; ++i) terms[i - j - 1] = a[i + j * n] * x[i];
    const double sum = sum_by_pairs(terms, n - 1 - j);
    x[j] -= several ? 0 + sum : sum;
  }
  for (int k = n - 1; k >= 0; --k) std::swap(x[k], x[swaps[k]]);
}

template <int N, int Columns>
Eigen::Matrix<double, N, Columns> solve(Eigen::Matrix<double, N, N> matrix, Eigen::Matrix<double, N, Columns> right) {
  const std::array<int, 6> swaps = factorise(N, matrix.data());
  for (int c = 0; c < Columns; ++c) substitute(N, matrix.data(), swaps, right.col(c).data(), Columns > 1);
  return right;
}

template <int N, int Columns>
Eigen::Matrix<double, N, Columns> balanced(const Eigen::Matrix<double, N, N>& matrix,
                                           const Eigen::Matrix<double, N, Columns>& right) {
  const Eigen::Matrix<double, N, 1> scale =
      matrix.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  return scale.asDiagonal() *
         solve<N, Columns>(scale.asDiagonal() * matrix * scale.asDiagonal(), scale.asDiagonal() * right);
}

}  // namespace

// A 2 x 2 matrix is tridiagonal. The solver's constructor would make it so; this alone takes eight seconds to compile.
Spectrum<2> spectrum_of(const Eigen::Matrix2d& symmetric) {
  const double largest = std::max({std::abs(symmetric(0, 0)), std::abs(symmetric(1, 0)), std::abs(symmetric(1, 1))});
  const double scale = largest > 0 ? largest : 1;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeFromTridiagonal(symmetric.diagonal() / scale, Eigen::Matrix<double, 1, 1>(symmetric(1, 0) / scale));
  return {solver.eigenvalues() * scale, solver.eigenvectors()};
}

Spectrum<3> spectrum_of(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Spectrum<3> direct_spectrum_of(const Eigen::Matrix3d& symmetric) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector2d solve_definite(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& right) {
  return solve(matrix, right);
}

Eigen::Vector3d solve_definite(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right) {
  return solve(matrix, right);
}

Eigen::Vector4d solve_definite(const Eigen::Matrix4d& matrix, const Eigen::Vector4d& right) {
  return solve(matrix, right);
}

Eigen::VectorXd solve_definite(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.ldlt().solve(right);
}

Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& matrix) {
  return matrix.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

Vector6 solve_balanced(const Matrix6& matrix, const Vector6& right) { return balanced(matrix, right); }

Eigen::Matrix3d balanced_inverse(const Eigen::Matrix3d& matrix) {
  return balanced<3, 3>(matrix, Eigen::Matrix3d::Identity());
}

}  // namespace isimp
