#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "marker/marker_plane.h"
#include "seater_perception/camera_model.h"

namespace seater_perception {

/// Rays of all pixels of a box, distortion inverted exactly on a grid and interpolated between (1e-4 px).
class RayGrid {
 public:
  /// False when a part of the box cannot be undistorted.
  bool make(const CameraModel& camera, int u0, int v0, int u1, int v1);
  PixelRay at(double u, double v) const;
  /// The camera has no distortion.
  bool linear() const { return linear_; }

 private:
  int u0_ = 0, v0_ = 0, columns_ = 0, rows_ = 0;
  bool linear_ = false;
  double fx_ = 1.0, fy_ = 1.0, cx_ = 0.0, cy_ = 0.0;
  std::vector<Eigen::Vector2d> nodes_;
};

}  // namespace seater_perception
