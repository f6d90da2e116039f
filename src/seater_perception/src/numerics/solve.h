// Small systems of equations. Eigen's solvers take the compiler three seconds in each file that uses one: it is this.
#pragma once

#include <Eigen/Core>

namespace seater_perception {

/// x with A x = b, by LDL' with pivoting; A symmetric and semi-definite.
Eigen::Vector3f solved(const Eigen::Matrix3f& A, const Eigen::Vector3f& b);
Eigen::Matrix<double, 6, 1> solved(const Eigen::Matrix<double, 6, 6>& A, const Eigen::Matrix<double, 6, 1>& b);

/// A^-1, by LU with partial pivoting; not finite where A is singular.
Eigen::Matrix<double, 6, 6> inverted(const Eigen::Matrix<double, 6, 6>& A);

}  // namespace seater_perception
