#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"

namespace seater_perception {

/// Points of an object and where they were seen.
struct Correspondences {
  std::vector<Eigen::Vector3d> object;      ///< in the object's frame [m]
  std::vector<Eigen::Vector2d> pixel;       ///< in the image [px]
  std::vector<Eigen::Vector2d> normalised;  ///< undistorted (x/z, y/z)
  std::vector<double> sigma;                ///< standard deviation of each of the pixel's coordinates [px]

  std::size_t size() const { return object.size(); }
  /// False, and nothing added, when the pixel cannot be undistorted.
  bool add(const Eigen::Vector3d& object_point, const Eigen::Vector2d& seen, double pixel_sigma,
           const CameraModel& camera);
  void append(const Correspondences& other);
};

/// Minimises the distance between seen and projected points in undistorted coordinates, beginning at `initial` (pose of
/// the object in the optical frame): ViSP's virtual visual servoing (Marchand and Chaumette, "Virtual visual servoing",
/// Eurographics 2002). Nothing when it ends not finite or with a point behind the camera.
std::optional<Eigen::Isometry3d> refinePose(const Correspondences& points, const Eigen::Isometry3d& initial);

/// Root mean square distance between seen and projected points [px]; infinite when a point is behind the camera.
double reprojectionError(const CameraModel& camera, const Correspondences& points, const Eigen::Isometry3d& pose);

/// Sum of the squared differences between seen and projected coordinates, each over its variance.
double chiSquared(const CameraModel& camera, const Correspondences& points, const Eigen::Isometry3d& pose);

/// Covariance of a pose, sigma^2 (J^T J)^-1, where sigma is the standard deviation of the seen coordinates and J the
/// derivative of all pixels (distortion included) by the pose. When the points' sigmas S differ, refinePose still
/// weighs them equally and the covariance is (J^T J)^-1 J^T S^2 J (J^T J)^-1.
///
/// Order x, y, z [m], rotation about x, y, z of the optical frame [rad]. The error (d, w) of an estimate (R, t) is
/// meant so: t_true = t + d, R_true = exp([w]x) R, i.e. the rotation is perturbed from the left, about the object's own
/// origin. Nothing when J^T J is so near to singular that the result would be meaningless.
std::optional<Matrix6d> poseCovariance(const CameraModel& camera, const Correspondences& points,
                                       const Eigen::Isometry3d& pose);

/// Covariance of T_a_b * T_b_c, with T_a_b's covariance given as above and T_b_c exact.
Matrix6d transportCovariance(const Matrix6d& covariance, const Eigen::Isometry3d& T_a_b,
                             const Eigen::Isometry3d& T_b_c);

/// Derivative of the pixel of a point by the pose, (d, w) as above. `arm` is the point turned into the optical frame,
/// R * point, and `point` the same displaced, R * point + t, in front of the camera [m].
Eigen::Matrix<double, 2, 6> pixelByPose(const CameraModel& camera, const Eigen::Vector3d& arm,
                                        const Eigen::Vector3d& point);

/// `a` moved by (d, w): t_a + d, exp([w]x) R_a.
Eigen::Isometry3d movedPose(const Eigen::Isometry3d& a, const Vector6d& change);

/// (d, w) with b = movedPose(a, (d, w)), the rotation's angle at most pi.
Vector6d poseDifference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// [rad] Angle of the rotation that takes one attitude to the other, 0 .. pi.
double turnBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// True when both poses are the same for practical purposes: within 0.001 rad, and 0.0001 of the distance.
bool samePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

}  // namespace seater_perception
