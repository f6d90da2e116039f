#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "pose/marker_pose.h"

namespace seater_perception {

/// A marker of the last image as a guess of what it looks like in this one, where its code was found at `seen`.
///
/// Each pose is moved so that its corners come to those of the code, but turned no more than an image's time allows:
/// small markers keep their tilt, large ones follow their corners. A single pose gets its mirror image about the line
/// of sight beside it, unless both are so far apart that the last image's decision still holds. What else is carried
/// on is the point spread function, where `seen` tells none. Covariances stay; chi_squared is 0. Nothing when a corner
/// cannot be projected.
std::optional<MarkerEstimate> expectedMarker(const CameraModel& camera, const MarkerEstimate& last,
                                             const MarkerCorners& seen);

}  // namespace seater_perception
