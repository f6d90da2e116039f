// Written out here because OpenCV's SOLVEPNP_IPPE_SQUARE returns wrong rotation vectors for exactly frontal markers
// (half a turn about an axis in the image) and NaN where rounding makes the argument of one of its square roots
// negative.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "pose/marker_pose.h"

namespace seater_perception {
namespace {

/// From the square -1 .. 1 to the image; `seen` are the images of (-1, 1), (1, 1), (1, -1), (-1, -1). An affine
/// function on the square has corners whose alternating sum vanishes; that of the homogeneous corners w (u, v, 1) gives
/// the last row of H, w = g x + h y + 1 (P. Heckbert, "Fundamentals of texture mapping and image warping", 1989).
bool homography(const std::vector<Eigen::Vector2d>& seen, Eigen::Matrix3d& H) {
  const Eigen::Vector2d &a = seen[0], &b = seen[1], &c = seen[2], &d = seen[3];
  Eigen::Matrix2d M;
  M << c + d - a - b, a + d - b - c;
  const Eigen::Vector2d last = M.inverse() * (b + d - a - c);
  const double g = last.x(), h = last.y();
  const Eigen::Vector2d p = (1.0 - g + h) * a, q = (1.0 + g + h) * b, r = (1.0 + g - h) * c, s = (1.0 - g - h) * d;
  H << 0.25 * (q + r - p - s), 0.25 * (p + q - r - s), 0.25 * (p + q + r + s), g, h, 1.0;
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

/// Translation t that fits best to the corners p under a rotation, in the least squares of x - z u. From the mean of
/// the corners, t_x - u t_z = u p_z - p_x leaves t_z alone.
Eigen::Vector3d translation(const Correspondences& corners, const Eigen::Matrix3d& R) {
  std::array<Eigen::Vector2d, 4> right;
  Eigen::Vector2d mean_seen = Eigen::Vector2d::Zero(), mean_right = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = R * corners.object[i];
    right[i] = p.z() * corners.normalised[i] - p.head<2>();
    mean_seen += 0.25 * corners.normalised[i];
    mean_right += 0.25 * right[i];
  }
  double products = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d seen = corners.normalised[i] - mean_seen;
    products += seen.dot(right[i] - mean_right);
    squares += seen.squaredNorm();
  }
  const double z = -products / squares;
  const Eigen::Vector2d xy = mean_right + z * mean_seen;
  return {xy.x(), xy.y(), z};
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
