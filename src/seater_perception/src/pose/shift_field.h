// Smooth shifts of the image: prints that are not flat, what is left of a lens' distortion, line jitter. Photographs
// show shifts of 0.1 to 0.3 px that are much the same over 8 to 20 px.
#pragma once

#include <optional>
#include <vector>

#include "pose/pose.h"
#include "seater_perception/detection.h"

namespace seater_perception {

/// Correlation of a field at two places that are so far `apart` [px]. The field is white noise smoothed by a Gaussian
/// of standard deviation `smoothness` [px].
double shiftCorrelation(const Eigen::Vector2d& apart, double smoothness);

/// What an image does that the model of the camera does not know.
struct ShiftEstimate {
  double alike = 1.0;        ///< factor of the fit's own variance: residuals of neighbouring pixels err together
  double sigma = 0.0;        ///< [px] standard deviation of smooth shifts, of each coordinate
  double smoothness = 14.0;  ///< [px] of them
};

/// The shifts in an image, by what fits of its markers have left over: means over all of ShiftGrid, each weighed by
/// its probability.
class ShiftField {
 public:
  /// `weight`: how much a marker counts; 1: as itself.
  void add(const ShiftEvidence& evidence, double weight);
  /// `usual`: standard deviation of shifts [px] that the prior rests on; 0: cameras are exactly as modelled unless
  /// markers tell otherwise. `as_modelled`: residuals do not tell that the camera is not, and there may be no shifts.
  ShiftEstimate estimate(double usual, bool as_modelled) const;

 private:
  ShiftGrid::Table seen_{};
};

/// Places on prints at which an image may be shifted.
struct ShiftedPlaces {
  std::vector<Eigen::Vector3d> object;  ///< in the object's frame [m]
  std::vector<double> sigma;            ///< standard deviation of the shift there [px]

  /// Those of a print of side `size` [m]. The pose that all its cells' edges give follows shifts as that of these
  /// places does (within 15 % of each standard deviation).
  void add(double size, const Eigen::Isometry3d& T_object_marker, double shift_sigma);
};

/// Covariance of a pose by the shifts of these places, all weighed equally; order as of PoseHypothesis::covariance.
/// Nothing when the pose is degenerate.
std::optional<Matrix6d> shiftCovariance(const CameraModel& camera, const ShiftedPlaces& places,
                                        const Eigen::Isometry3d& pose, double smoothness);

}  // namespace seater_perception
