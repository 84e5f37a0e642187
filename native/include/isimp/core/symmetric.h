#pragma once

#include <Eigen/Core>

namespace isimp {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Eigenvalues of a symmetric matrix, rising, and the unit eigenvector of each as a column.
template <int N>
struct Spectrum {
  Eigen::Matrix<double, N, 1> values;
  Eigen::Matrix<double, N, N> vectors;
};

/// By QR steps, with an error of some roundings of the largest value. Only the lower triangle is read. Cost: O(N^3).
Spectrum<2> spectrum_of(const Eigen::Matrix2d& symmetric);
Spectrum<3> spectrum_of(const Eigen::Matrix3d& symmetric);

/// In closed form: some times faster, and less exact where two values are close.
Spectrum<3> direct_spectrum_of(const Eigen::Matrix3d& symmetric);

/// The x with `matrix` x = `right` for a symmetric positive semi-definite matrix, by LDL^T with pivots. Cost: O(N^3).
Eigen::Vector2d solve_definite(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& right);
Eigen::Vector3d solve_definite(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right);
Eigen::Vector4d solve_definite(const Eigen::Matrix4d& matrix, const Eigen::Vector4d& right);
Eigen::VectorXd solve_definite(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

/// The inverse of a symmetric positive definite matrix, by Cholesky's factors. Cost: O(N^3).
Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& matrix);

/// As solve_definite, for unknowns of different units, such as turns and lengths. Rows and columns are scaled to a
/// diagonal of 1 first. So the order of elimination, and with it every bit of the result, does not depend on the unit of
/// length.
Vector6 solve_balanced(const Matrix6& matrix, const Vector6& right);
Eigen::Matrix3d balanced_inverse(const Eigen::Matrix3d& matrix);

}  // namespace isimp
