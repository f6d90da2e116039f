// The two poses under which a marker looks nearly the same: where fits have to begin so that neither is missed.
#pragma once

#include <vector>

#include "pose/marker_pose.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// [px] side from which on a marker is large: noise in its corners leaves one pose of two, and no longer makes up a
/// pattern. Chosen by hand; `perception_accuracy` (wrong branches) and initial_poses_test notice.
constexpr double kLargeMarker = 40.0;

/// The other pose under which a marker far away looks the same: its depths along the line of sight change sign.
/// Exact for parallel projection; an involution.
Eigen::Isometry3d mirrored(const Eigen::Isometry3d& T_optical_marker);

/// Turned about its centre until its normal is at least `angle` [rad] off the line of sight, away from the latter.
Eigen::Isometry3d tilted(const Eigen::Isometry3d& T_optical_marker, double angle);

/// Poses that the corners cannot tell apart.
std::vector<Eigen::Isometry3d> openPoses(const MarkerEstimate& marker);

/// Noise in the corners of a small marker often leaves one pose of two, and both may come to the same minimum: true
/// when the other one has not been looked at. `branches`: of openPoses; `hypotheses`: the distinct ones among them.
bool otherBranchOpen(const MarkerEstimate& marker, const std::vector<PhotometricBranch>& branches,
                     const std::vector<PoseHypothesis>& hypotheses);

/// The pose found and, for both branches, one so steep that its fit comes down to its own minimum: near the line of
/// sight the image hardly changes with the tilt, steps are long, and a fit from there may go over to the other
/// branch.
std::vector<Eigen::Isometry3d> steepPoses(const Eigen::Isometry3d& found);

}  // namespace seater_perception
