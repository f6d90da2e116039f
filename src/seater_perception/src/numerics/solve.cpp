#include "numerics/solve.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace seater_perception {

Eigen::Vector3f solved(const Eigen::Matrix3f& A, const Eigen::Vector3f& b) {
  return A.ldlt().solve(b);
}

Eigen::Matrix<double, 6, 1> solved(const Eigen::Matrix<double, 6, 6>& A, const Eigen::Matrix<double, 6, 1>& b) {
  return A.ldlt().solve(b);
}

Eigen::Matrix<double, 6, 6> inverted(const Eigen::Matrix<double, 6, 6>& A) {
  return A.inverse();
}

}  // namespace seater_perception
