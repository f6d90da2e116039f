#include "pose/pose.h"

#include <visp3/vision/vpPose.h>

#include <cmath>
#include <limits>

#include "numerics/skew.h"
#include "numerics/symmetric.h"

namespace seater_perception {
namespace {

constexpr double kVvsEpsilon = 1e-18;         // change of the squared error, in undistorted coordinates: 1e-6 px
constexpr int kVvsSteps = 100;                // ends what does not converge
constexpr double kSmallestEigenvalue = 1e-9;  // of J^T J scaled to a unit diagonal; double precision resolves 1e-15

vpHomogeneousMatrix toVisp(const Eigen::Isometry3d& pose) {
  vpHomogeneousMatrix result;
  for (unsigned row = 0; row < 3; ++row) {
    for (unsigned column = 0; column < 4; ++column) result[row][column] = pose.matrix()(row, column);
  }
  return result;
}

Eigen::Isometry3d fromVisp(const vpHomogeneousMatrix& pose) {
  Eigen::Matrix3d R;
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (unsigned row = 0; row < 3; ++row) {
    for (unsigned column = 0; column < 3; ++column) R(row, column) = pose[row][column];
    result.translation()[row] = pose[row][3];
  }
  result.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  return result;
}

/// Of what the points are off in the image [px], each over `variance(i)`; infinite when one is behind the camera.
template <typename Variance>
double sumOfSquares(const CameraModel& camera, const Correspondences& points, const Eigen::Isometry3d& pose,
                    Variance variance) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = camera.project(pose * points.object[i]);
    if (!pixel) return std::numeric_limits<double>::infinity();
    sum += (*pixel - points.pixel[i]).squaredNorm() / variance(i);
  }
  return sum;
}

}  // namespace

bool Correspondences::add(const Eigen::Vector3d& object_point, const Eigen::Vector2d& seen, double pixel_sigma,
                          const CameraModel& camera) {
  const auto undistorted = camera.undistort(seen);
  if (!undistorted) return false;
  object.push_back(object_point);
  pixel.push_back(seen);
  normalised.push_back(*undistorted);
  sigma.push_back(pixel_sigma);
  return true;
}

void Correspondences::append(const Correspondences& other) {
  object.insert(object.end(), other.object.begin(), other.object.end());
  pixel.insert(pixel.end(), other.pixel.begin(), other.pixel.end());
  normalised.insert(normalised.end(), other.normalised.begin(), other.normalised.end());
  sigma.insert(sigma.end(), other.sigma.begin(), other.sigma.end());
}

std::optional<Eigen::Isometry3d> refinePose(const Correspondences& points, const Eigen::Isometry3d& initial) {
  if (points.size() < 4 || !initial.matrix().allFinite()) return std::nullopt;
  vpPose servo;
  for (std::size_t i = 0; i < points.size(); ++i) {
    vpPoint point(points.object[i].x(), points.object[i].y(), points.object[i].z());
    point.set_x(points.normalised[i].x());
    point.set_y(points.normalised[i].y());
    servo.addPoint(point);
  }
  servo.setVvsEpsilon(kVvsEpsilon);
  servo.setVvsIterMax(kVvsSteps);
  vpHomogeneousMatrix pose = toVisp(initial);
  try {
    servo.computePose(vpPose::VIRTUAL_VS, pose);
  } catch (const vpException&) {
    return std::nullopt;  // its matrices became singular or not finite
  }
  const Eigen::Isometry3d result = fromVisp(pose);
  if (!result.matrix().allFinite()) return std::nullopt;
  for (const auto& point : points.object) {
    if (!((result * point).z() > 1e-6)) return std::nullopt;
  }
  return result;
}

double reprojectionError(const CameraModel& camera, const Correspondences& points, const Eigen::Isometry3d& pose) {
  const double sum = sumOfSquares(camera, points, pose, [](std::size_t) { return 1.0; });
  return std::sqrt(sum / static_cast<double>(points.size()));
}

double chiSquared(const CameraModel& camera, const Correspondences& points, const Eigen::Isometry3d& pose) {
  return sumOfSquares(camera, points, pose, [&points](std::size_t i) { return points.sigma[i] * points.sigma[i]; });
}

std::optional<Matrix6d> poseCovariance(const CameraModel& camera, const Correspondences& points,
                                       const Eigen::Isometry3d& pose) {
  Matrix6d information = Matrix6d::Zero(), noise = Matrix6d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d arm = pose.linear() * points.object[i];
    const Eigen::Vector3d point = arm + pose.translation();
    if (!(point.z() > 1e-6)) return std::nullopt;
    const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, point);
    information += J.transpose() * J;
    noise += points.sigma[i] * points.sigma[i] * J.transpose() * J;
  }
  // Metres and radians differ by orders of magnitude: judge and invert it scaled to a unit diagonal.
  const Vector6d scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Matrix6d scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const auto modes = modesOf(scaled);
  if (!modes || !(modes->values[0] > kSmallestEigenvalue)) return std::nullopt;
  const Matrix6d vectors = modes->vectors;
  const Matrix6d inverse = vectors * Vector6d(modes->values.cwiseInverse()).asDiagonal() * vectors.transpose();
  const Matrix6d unscaled = scale.asDiagonal() * inverse * scale.asDiagonal();
  const Matrix6d covariance = unscaled * noise * unscaled;
  if (!covariance.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (covariance + covariance.transpose()));
}

Matrix6d transportCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T_a_b,
                             const Eigen::Isometry3d& T_b_c) {
  Matrix6d A = Matrix6d::Identity();
  A.topRightCorner<3, 3>() = -skew(T_a_b.linear() * T_b_c.translation());
  return A * covariance * A.transpose();
}

Eigen::Matrix<double, 2, 6> pixelByPose(const CameraModel& camera, const Eigen::Vector3d& arm,
                                        const Eigen::Vector3d& point) {
  const Eigen::Matrix<double, 2, 3> by_point = camera.projectionJacobian(point);
  Eigen::Matrix<double, 2, 6> J;
  J << by_point, -by_point * skew(arm);
  return J;
}

Eigen::Isometry3d movedPose(const Eigen::Isometry3d& a, const Vector6d& change) {
  Eigen::Isometry3d b = a;
  b.translation() += change.head<3>();
  const Eigen::Vector3d turn = change.tail<3>();
  const double angle = turn.norm();
  if (angle > 0.0) b.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * a.linear();
  return b;
}

Vector6d poseDifference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::AngleAxisd turn(b.linear() * a.linear().transpose());
  Vector6d difference;
  difference << b.translation() - a.translation(), turn.angle() * turn.axis();
  return difference;
}

double turnBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

bool samePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const double angle = turnBetween(a, b);
  const double distance = (a.translation() - b.translation()).norm();
  return angle < 1e-3 && distance < 1e-4 * a.translation().norm();
}

}  // namespace seater_perception
