#pragma once

#include <Eigen/Geometry>

namespace seater_perception {

/// A ray of the camera and how it changes over the image.
struct PixelRay {
  double x = 0.0, y = 0.0;                                        ///< undistorted coordinates x/z, y/z
  double x_by_u = 0.0, x_by_v = 0.0, y_by_u = 0.0, y_by_v = 0.0;  ///< derivatives by the pixel [1/px]
};

/// Symmetric 2x2 covariance of the point-spread function [px^2].
struct SpreadCovariance {
  double uu = 0.0, uv = 0.0, vv = 0.0;
};

/// Where the ray of a pixel meets a marker, and how that changes with the pixel.
struct MarkerHit {
  double x = 0.0, y = 0.0;                            ///< [m] in the marker frame
  double gxu = 0.0, gxv = 0.0, gyu = 0.0, gyv = 0.0;  ///< derivative of (x, y) by the pixel [m/px]
};

/// A marker's plane as seen from the camera.
class MarkerPlane {
 public:
  /// Pose of the marker frame in the optical frame.
  explicit MarkerPlane(const Eigen::Isometry3d& pose);

  /// False when the marker is edge-on or behind the camera along this ray.
  bool hit(const PixelRay& ray, MarkerHit& hit) const;

 private:
  Eigen::Vector3d r1_, r2_, r3_;  // axes of the marker in the optical frame
  double t1_, t2_, t3_;           // its origin along these axes
};

}  // namespace seater_perception
