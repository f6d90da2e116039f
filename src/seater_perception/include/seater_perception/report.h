#pragma once

#include <optional>
#include <string>

#include "seater_perception/detection.h"

namespace seater_perception {

/// Where a marker or dock is, as people read it.
struct Placement {
  double distance = 0.0;  ///< from the camera to the object's origin [m]
  double lateral = 0.0;   ///< object right of the optical axis [m]
  double angle = 0.0;     ///< see the two functions [rad]
};

/// `angle`: by which the print is turned away from the camera's image plane, about the vertical; 0: seen square on,
/// positive: its right edge is nearer.
Placement markerPlacement(const Eigen::Isometry3d& T_optical_marker);
/// `angle`: heading of the dock's x axis, seen from the camera; 0: along the optical axis, positive: to the left.
Placement dockPlacement(const Eigen::Isometry3d& T_optical_dock);

/// A table of one image's markers and of the dock, millimetres and degrees.
std::string table(const DetectionResult& result);

/// One JSON object: SI units and radians, poses as position and quaternion (x y z w) in the optical frame; a marker's
/// `ambiguity` as of DetectedMarker.
std::string json(const std::string& image, const DetectionResult& result, const std::optional<std::string>& drawing);

}  // namespace seater_perception
