// Written out here because OpenCV's SOLVEPNP_IPPE_SQUARE returns wrong rotation vectors for exactly frontal markers
// (half a turn about an axis in the image) and NaN where rounding makes the argument of one of its square roots
// negative.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "pose/marker_pose.h"

namespace seater_perception {
namespace {

/// From the square -1 .. 1 to the image; `seen` are the images of (-1, 1), (1, 1), (1, -1), (-1, -1).
bool homography(const std::vector<Eigen::Vector2d>& seen, Eigen::Matrix3d& H) {
  static const double x[] = {-1.0, 1.0, 1.0, -1.0}, y[] = {1.0, 1.0, -1.0, -1.0};
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d& p = seen[static_cast<std::size_t>(i)];
    A.row(2 * i) << x[i], y[i], 1.0, 0.0, 0.0, 0.0, -p.x() * x[i], -p.x() * y[i];
    A.row(2 * i + 1) << 0.0, 0.0, 0.0, x[i], y[i], 1.0, -p.y() * x[i], -p.y() * y[i];
    b.segment<2>(2 * i) = p;
  }
  const Eigen::Matrix<double, 8, 1> h = A.partialPivLu().solve(b);
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0;
  return H.allFinite();
}

/// The shortest turn that takes the optical axis to a unit vector in front of the camera: Rodrigues' formula. (Eigen's
/// FromTwoVectors has to care for opposite vectors, too, with a decomposition that takes the compiler half a minute.)
Eigen::Matrix3d fromOpticalAxis(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), n = 1.0 / (1.0 + d.z());
  Eigen::Matrix3d R;
  R << 1.0 - n * x * x, -n * x * y, x, -n * x * y, 1.0 - n * y * y, y, -x, -y, d.z();
  return R;
}

/// Translation that fits best to the corners under a rotation, in the least squares of x - z u.
Eigen::Vector3d translation(const Correspondences& corners, const Eigen::Matrix3d& R) {
  Eigen::Matrix<double, 8, 3> A;
  Eigen::Matrix<double, 8, 1> b;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = R * corners.object[i];
    for (int k = 0; k < 2; ++k) {
      const int row = static_cast<int>(2 * i) + k;
      A.row(row) << (k == 0 ? 1.0 : 0.0), (k == 1 ? 1.0 : 0.0), -corners.normalised[i][k];
      b[row] = corners.normalised[i][k] * p.z() - p[k];
    }
  }
  return A.colPivHouseholderQr().solve(b);
}

double squaredError(const Correspondences& corners, const Eigen::Isometry3d& pose) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    sum += ((pose * corners.object[i]).hnormalized() - corners.normalised[i]).squaredNorm();
  return sum;
}

}  // namespace

std::vector<Eigen::Isometry3d> squareSolutions(const Correspondences& corners) {
  std::vector<Eigen::Isometry3d> solutions;
  Eigen::Matrix3d H;
  if (corners.size() != 4 || !homography(corners.normalised, H)) return solutions;
  // The image of the square's middle, and how the image changes about it.
  const Eigen::Vector2d v = H.block<2, 1>(0, 2);
  const Eigen::Matrix2d J = H.topLeftCorner<2, 2>() - v * H.block<1, 2>(2, 0);
  const Eigen::Matrix3d Rv = fromOpticalAxis(v.homogeneous().normalized());
  const Eigen::Matrix2d B = Rv.topLeftCorner<2, 2>() - v * Rv.block<1, 2>(2, 0);
  const Eigen::Matrix2d A = B.inverse() * J;
  // The larger singular value is what a length along the axis of the tilt is scaled by.
  const double squares = A.squaredNorm(), det = A.determinant();
  const double scale = std::sqrt(0.5 * (squares + std::sqrt(std::max(0.0, squares * squares - 4.0 * det * det))));
  const Eigen::Matrix2d inner = A / scale;
  if (!inner.allFinite()) return solutions;
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - inner.transpose() * inner;
  Eigen::Vector2d b(std::sqrt(std::max(0.0, rest(0, 0))), std::sqrt(std::max(0.0, rest(1, 1))));
  if (rest(0, 1) < 0.0) b.y() = -b.y();
  for (const double sign : {1.0, -1.0}) {
    Eigen::Vector3d first, second;
    first << inner.col(0), sign * b.x();
    second << inner.col(1), sign * b.y();
    first.normalize();
    second = (second - second.dot(first) * first).normalized();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << Rv * first, Rv * second, Rv * first.cross(second);
    pose.translation() = translation(corners, pose.linear());
    if (pose.matrix().allFinite()) solutions.push_back(pose);
  }
  std::sort(solutions.begin(), solutions.end(), [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& c) {
    return squaredError(corners, a) < squaredError(corners, c);
  });
  return solutions;
}

}  // namespace seater_perception
