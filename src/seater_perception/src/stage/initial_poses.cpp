#include "stage/initial_poses.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// Chosen by hand; `perception_accuracy` (wrong branches) and the tests here notice.
constexpr double kClearlyWorse = 15.0;  // of chi-squared: exp(-7.5), 1 in 1800: the corners have decided
constexpr double kSteep = 0.17;         // [rad] 10 deg: beyond, fits come down to their own minimum

}  // namespace

Eigen::Isometry3d mirrored(const Eigen::Isometry3d& T_optical_marker) {
  const Eigen::Vector3d sight = T_optical_marker.translation().normalized();
  const auto reflected = [&sight](const Eigen::Vector3d& axis) {
    return Eigen::Vector3d(axis - 2.0 * sight.dot(axis) * sight);
  };
  const Eigen::Vector3d x = reflected(T_optical_marker.linear().col(0)),
                        y = reflected(T_optical_marker.linear().col(1));
  Eigen::Isometry3d result = T_optical_marker;
  result.linear() << x, y, x.cross(y);
  return result;
}

Eigen::Isometry3d tilted(const Eigen::Isometry3d& T_optical_marker, double angle) {
  const Eigen::Vector3d sight = -T_optical_marker.translation().normalized();
  const Eigen::Vector3d normal = T_optical_marker.linear().col(2);
  const double now = std::acos(std::clamp(sight.dot(normal), -1.0, 1.0));
  if (now >= angle) return T_optical_marker;
  Eigen::Vector3d axis = sight.cross(normal);
  axis = axis.norm() > 1e-9 ? axis.normalized() : sight.unitOrthogonal();
  Eigen::Isometry3d result = T_optical_marker;
  result.linear() = Eigen::AngleAxisd(angle - now, axis).toRotationMatrix() * T_optical_marker.linear();
  return result;
}

std::vector<Eigen::Isometry3d> openPoses(const MarkerEstimate& marker) {
  double smallest = marker.hypotheses.front().chi_squared;
  for (const auto& h : marker.hypotheses) smallest = std::min(smallest, h.chi_squared);
  std::vector<Eigen::Isometry3d> poses;
  for (const auto& h : marker.hypotheses) {
    const bool decided = marker.image.edges_fitted && marker.image.side() > kLargeMarker;
    if (!decided || h.chi_squared - smallest < kClearlyWorse) poses.push_back(h.pose);
  }
  return poses;
}

bool otherBranchOpen(const MarkerEstimate& marker, const std::vector<PhotometricBranch>& branches,
                     const std::vector<PoseHypothesis>& hypotheses) {
  const bool small = marker.image.side() <= kLargeMarker;
  return small && !marker.branch_known && hypotheses.size() == 1 &&
         std::none_of(branches.begin(), branches.end(), [](const PhotometricBranch& b) { return b.hopeless; });
}

std::vector<Eigen::Isometry3d> steepPoses(const Eigen::Isometry3d& found) {
  return {found, tilted(found, kSteep), tilted(mirrored(found), kSteep)};
}

}  // namespace seater_perception
