#pragma once

#include <string>
#include <vector>

#include "pose/marker_pose.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {

/// Pose of the dock from its markers in one image, most probable first; several when the image does not decide.
///
/// "lowest_id": the visible marker with the lowest id alone. "bundle": all corners of all visible markers, refined
/// together; a marker that contradicts the others (wrong place, wrong id) is left out as long as at least two others
/// agree. When only two are seen and contradict each other, both poses are given. Markers that are not in the layout
/// are ignored.
///
/// `up`: unit vector pointing up, in the optical frame.
std::vector<DockHypothesis> estimateDock(const CameraModel& camera, const std::vector<MarkerEstimate>& markers,
                                         const DockLayout& layout, const std::string& selection,
                                         const Eigen::Vector3d& up, const PoseParameters& parameters);

/// Adds what prints that hang beside their places do to the pose: `sigma` [m] along each axis, each print by itself.
void addPlacementError(const CameraModel& camera, const DockLayout& layout, double sigma,
                       std::vector<DockHypothesis>& dock);

}  // namespace seater_perception
