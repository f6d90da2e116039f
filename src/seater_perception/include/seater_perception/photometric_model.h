#pragma once

#include <Eigen/Geometry>

#include "seater_perception/marker_pattern.h"

namespace seater_perception {

/// Grey level (0 black, 1 white) of a marker's pattern smoothed by a Gaussian, and its derivatives.
struct PatternResponse {
  double value = 0.0;
  double by_x = 0.0, by_y = 0.0;            ///< by the place, per cell
  double by_log_sx = 0.0, by_log_sy = 0.0;  ///< by the logarithm of the Gaussian's standard deviations
  double by_rho = 0.0;                      ///< by its correlation
  bool flat = true;                         ///< true: no cell border within reach, all derivatives are 0
};

/// The pattern at (x, y) [cells from its lower left corner, y up], smoothed by a Gaussian of standard deviations sx, sy
/// [cells] along the cells and correlation rho. Exact for an edge between two cells; where edges cross, the bivariate
/// normal integral is taken from its series in rho up to the fourth order (M. G. Kendall, "Proof of relations connected
/// with the tetrachoric series", Biometrika 1941): 1e-4 of the contrast at |rho| = 0.35, which is a tilt of 45 deg
/// about a diagonal.
PatternResponse smoothedPattern(const MarkerPattern& pattern, double x, double y, double sx, double sy, double rho);

/// A ray of the camera and how it changes over the picture.
struct PixelRay {
  double x = 0.0, y = 0.0;                                        ///< undistorted coordinates x/z, y/z
  double x_by_u = 0.0, x_by_v = 0.0, y_by_u = 0.0, y_by_v = 0.0;  ///< derivatives by the pixel [1/px]
};

/// Symmetric 2x2 covariance of the point-spread function [px^2].
struct SpreadCovariance {
  double uu = 0.0, uv = 0.0, vv = 0.0;
};

/// Where the ray of a pixel meets a marker, and how wide the pixel's point-spread function is there.
struct MarkerHit {
  double x = 0.0, y = 0.0;                            ///< [m] in the marker frame
  double alpha = 0.0, beta = 0.0;                     ///< slope of the ray against the marker's normal
  double gxu = 0.0, gxv = 0.0, gyu = 0.0, gyv = 0.0;  ///< derivative of (x, y) by the pixel [m/px]
  double sx = 0.0, sy = 0.0;                ///< standard deviations of the point-spread function on the marker [m]
  double rho = 0.0;                         ///< its correlation
  double ratio = 1.0, inverse_ratio = 1.0;  ///< sy / sx, sx / sy
};

/// A marker's plane as seen from the camera.
class MarkerPlane {
 public:
  /// Pose of the marker frame in the optical frame.
  explicit MarkerPlane(const Eigen::Isometry3d& pose);

  /// False when the marker is edge-on or behind the camera along this ray.
  bool hit(const PixelRay& ray, const SpreadCovariance& spread, MarkerHit& hit) const;

  /// Derivative of the response by a small motion of the marker: translation and rotation along the MARKER's axes, in
  /// metres and radians (t' = t + R d, R' = R exp([w]x)). `per_metre`: cells in a metre.
  void derivativeByMotion(const MarkerHit& hit, const PatternResponse& response, double per_metre,
                          double by_motion[6]) const;

 private:
  Eigen::Vector3d r1_, r2_, r3_;  // axes of the marker in the optical frame
  double t1_, t2_, t3_;           // its origin along these axes
  double inverse_t3_;
};

/// Derivative of the response by the covariance's elements uu, uv, vv [1/px^2].
void derivativeBySpread(const MarkerHit& hit, const PatternResponse& response, double by_spread[3]);

}  // namespace seater_perception
