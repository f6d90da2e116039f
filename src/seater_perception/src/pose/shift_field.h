// Smooth shifts of the image: prints that are not flat, what is left of a lens' distortion, line jitter. Photographs
// show shifts of 0.1 to 0.3 px that are much the same over 8 to 20 px.
#pragma once

#include <optional>
#include <vector>

#include "pose/pose.h"

namespace seater_perception {

/// [px] Smoothness: a field is white noise smoothed by a Gaussian of this standard deviation. Nobody knows it in
/// advance. The smoother a field, the more of it the fitted pose follows and the less is left over to show it: what
/// shows is taken for that of a smooth one, and does to poses what one of middling smoothness does.
constexpr double kShownSmoothness = 20.0, kUsualSmoothness = 14.0;

/// Correlation of a field at two places that are so far `apart` [px].
double shiftCorrelation(const Eigen::Vector2d& apart, double smoothness);

/// The variance of shifts in an image, by what fits of its markers have left over.
class ShiftField {
 public:
  /// One direction of a marker's ShiftEvidence (photometric.h). `weight`: how much it counts; 1: as one.
  void add(double information, double square, double weight);
  /// [px^2] of each coordinate. `usual`: standard deviation [px] that is expected where markers do not tell. Quadratic
  /// estimate of a variance component (C. R. Rao, "Estimation of variance and covariance components - MINQUE theory",
  /// Journal of Multivariate Analysis 1971), iterated, plus a part of its own standard deviation.
  double variance(double usual) const;

 private:
  struct Mode {
    double information, square, weight;
  };
  std::vector<Mode> modes_;
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
                                        const Eigen::Isometry3d& pose);

}  // namespace seater_perception
