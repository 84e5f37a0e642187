// One source for the solvers of Eigen: the compiler takes seconds for each of them.
#include "isimp/core/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace isimp {
namespace {

template <class Matrix>
Spectrum<Matrix::RowsAtCompileTime> by_steps(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <class Matrix, class Right>
Right balanced(const Matrix& matrix, const Right& right) {
  using Column = Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>;
  const Column scale = matrix.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  const Matrix scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right);
}

}  // namespace

Spectrum<2> spectrum_of(const Eigen::Matrix2d& symmetric) { return by_steps(symmetric); }
Spectrum<3> spectrum_of(const Eigen::Matrix3d& symmetric) { return by_steps(symmetric); }

Spectrum<3> direct_spectrum_of(const Eigen::Matrix3d& symmetric) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector2d solve_definite(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& right) {
  return matrix.ldlt().solve(right);
}

Eigen::Vector3d solve_definite(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right) {
  return matrix.ldlt().solve(right);
}

Eigen::Vector4d solve_definite(const Eigen::Matrix4d& matrix, const Eigen::Vector4d& right) {
  return matrix.ldlt().solve(right);
}

Eigen::VectorXd solve_definite(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.ldlt().solve(right);
}

Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& matrix) {
  return matrix.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

Vector6 solve_balanced(const Matrix6& matrix, const Vector6& right) { return balanced(matrix, right); }

Eigen::Matrix3d balanced_inverse(const Eigen::Matrix3d& matrix) {
  return balanced(matrix, Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
}

}  // namespace isimp
