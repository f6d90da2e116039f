#include "pipeline/expected_marker.h"

#include <algorithm>
#include <cmath>

#include "numerics/solve.h"
#include "seater_perception/dock_layout.h"
#include "stage/initial_poses.h"

namespace seater_perception {
namespace {

constexpr double kCornerSd = 0.1;  // [px] of the code's corners, small markers (docs/explanation/perception.md)
constexpr double kTurnSd = 0.02;   // [rad] from image to image, about each axis: 0.6 rad/s at 30 Hz
constexpr int kSteps = 2;          // Gauss-Newton: the poses are near
// Between the normal and the line of sight, from which on a decision for one of the two tilts holds. Chosen by hand;
// the tests of tilts here and `perception_accuracy` (wrong branches) notice.
constexpr double kSmallestTilt = 0.15;  // [rad]
constexpr double kTiltSds = 2.0;        // [standard deviations]

/// The same but for the turn, most probable when corners were seen there.
std::optional<Eigen::Isometry3d> probablePose(const CameraModel& camera, const Eigen::Isometry3d& last, double size,
                                              const MarkerCorners& seen) {
  const auto corners = markerCorners(size);
  Eigen::Isometry3d pose = last;
  for (int step = 0; step < kSteps; ++step) {
    Matrix6d H = Matrix6d::Zero();
    const Vector6d turned = poseDifference(pose, last);
    Vector6d g = Vector6d::Zero();
    for (int k = 3; k < 6; ++k) H(k, k) = std::pow(kCornerSd / kTurnSd, 2), g[k] = H(k, k) * turned[k];
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d arm = pose.linear() * corners[i], point = arm + pose.translation();
      const auto pixel = camera.project(point);
      if (!pixel) return std::nullopt;
      const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, point);
      H.noalias() += J.transpose() * J;
      g.noalias() += J.transpose() * (seen.corners[i] - *pixel);
    }
    const Vector6d change = solved(H, g);
    if (!change.allFinite()) return std::nullopt;
    pose = movedPose(pose, change);
  }
  return pose;
}

bool decided(const MarkerEstimate& marker) {
  const PoseHypothesis& h = marker.best();
  const double cosine = std::abs(h.pose.linear().col(2).dot(h.pose.translation().normalized()));
  const double sd = std::sqrt(h.covariance.bottomRightCorner<3, 3>().trace());
  return marker.hypotheses.size() == 1 && std::acos(std::min(1.0, cosine)) > std::max(kSmallestTilt, kTiltSds * sd);
}

}  // namespace

std::optional<MarkerEstimate> expectedMarker(const CameraModel& camera, const MarkerEstimate& last,
                                             const MarkerCorners& seen) {
  MarkerEstimate marker = last;
  marker.image = seen;
  if (!(seen.psf_sd > 0.0)) marker.image.psf_sd = last.image.psf_sd;
  marker.branch_known = decided(last);
  if (marker.hypotheses.size() == 1 && !marker.branch_known) {
    marker.hypotheses.push_back(marker.hypotheses.front());
    marker.hypotheses.back().pose = mirrored(marker.best().pose);
  }
  for (PoseHypothesis& h : marker.hypotheses) {
    const auto pose = probablePose(camera, h.pose, last.size, seen);
    if (!pose) return std::nullopt;
    h.pose = *pose;
    h.chi_squared = 0.0;
  }
  return marker;
}

}  // namespace seater_perception
