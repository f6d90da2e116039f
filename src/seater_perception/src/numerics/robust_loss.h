#pragma once

namespace seater_perception {

/// How much a residual counts: Huber's convex loss, or Tukey's, which forgets outliers (Huber, "Robust Statistics",
/// 1981).
enum class RobustLoss { huber, tukey };

constexpr double kHuber = 1.345;  // [scales] 95 % efficient with normal noise

/// The range of grey levels that the sensor can tell.
struct ClipRange {
  double low = 0.0, high = 255.0;
};

/// Mean of a normally distributed grey level of this mean and standard deviation once it has been clipped, and the
/// derivative by the mean.
double clippedMean(double mean, double sd, const ClipRange& range, double& by_mean);
/// [standard deviations] from the sensor's limits: nothing is clipped beyond.
constexpr double kClipReach = 4.0;

/// Sums over residuals at a scale; invalid ones do not count.
struct LossSums {
  double all = 0.0, inliers = 0.0;     ///< how many
  double cost = 0.0;                   ///< of the loss [grey levels^2]
  double weights = 0.0, slopes = 0.0;  ///< of weights, of the derivatives of weight times residual
  double squares = 0.0;                ///< of residuals [grey levels^2]
  double weighted = 0.0, psi2 = 0.0;   ///< of weight times, and of weight squared times, the square
};
LossSums sumLoss(const float* residual, const float* valid, int count, double scale, RobustLoss loss, double tukey);

}  // namespace seater_perception
