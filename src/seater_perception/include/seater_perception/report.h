#pragma once

#include <optional>
#include <string>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"
#include "seater_perception/dock_layout.h"

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

/// What a dock's markers, seen from the side, tell of the focal length.
struct FocalCheck {
  double excess = 0.0;  ///< the calibration's focal length over the one that fits best, less 1
  double sigma = 0.0;   ///< standard deviation of it: corners to a tenth of a pixel, prints not quite in their places

  /// Whether the markers contradict the calibration: clearly, and by more than a calibration is usually off.
  bool contradicts() const;
};

/// Focal length as a seventh unknown beside the dock's pose, by the corners of all of its markers in one image (one
/// step of least squares from the dock's first pose). Nothing with fewer than two markers, or where they do not tell: a
/// flat dock seen head-on never does. `placement_sigma`: of each print's place along each axis [m].
std::optional<FocalCheck> checkFocalLength(const CameraModel& camera, const DockLayout& layout,
                                           const DetectionResult& result, double placement_sigma);

/// A table of one image's markers and of the dock, millimetres and degrees.
std::string table(const DetectionResult& result);

/// One JSON object: SI units and radians, poses as position and quaternion (x y z w) in the optical frame; a marker's
/// `ambiguity` as of DetectedMarker.
std::string json(const std::string& image, const DetectionResult& result, const std::optional<std::string>& drawing);

}  // namespace seater_perception
