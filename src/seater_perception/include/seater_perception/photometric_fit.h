#pragma once

#include <optional>
#include <vector>

#include "seater_perception/photometric_samples.h"

namespace seater_perception {

/// All unknowns of a photometric fit.
struct PhotometricState {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  SpreadCovariance blur;  ///< of the lens, pixel area not included; may be slightly negative
  std::vector<Brightness> brightness;
};

/// How much a residual counts.
enum class RobustLoss { huber, tukey };

/// The range of grey levels that the sensor can tell.
struct ClipRange {
  double low = 0.0, high = 255.0;
};

/// Mean of a normally distributed grey level of this mean and standard deviation once it has been clipped, and the
/// derivative by the mean.
double clippedMean(double mean, double sd, const ClipRange& range, double& by_mean);

/// The least-squares problem: residuals, their derivatives, normal equations. Unknowns: motion of the object (6, order
/// and meaning as in pose.h), blur (0, 1 or 3), brightness of each marker (2 or 4), the latter eliminated marker by
/// marker (Schur complement).
class PhotometricProblem {
 public:
  enum class Blur { given = 0, round = 1, directed = 3 };

  PhotometricProblem(const std::vector<PatternPlacement>& placements, const std::vector<MarkerSamples>& samples,
                     Blur blur, bool slopes, ClipRange range);

  /// Offset and gain from the darkest and the lightest quarter of the pattern.
  void startBrightness(PhotometricState& state) const;

  /// Residuals and normal equations at a state, on every `stride`-th pixel. `scale`: noise the loss is measured with
  /// [grey levels]; `tukey`: its limit in scales. False when the state is impossible (behind the camera, negative
  /// contrast).
  bool evaluate(const PhotometricState& state, double scale, RobustLoss loss, double tukey, int stride);
  /// Sum of the loss over the residuals of the last evaluation, for another scale [grey levels^2].
  double cost(double scale, RobustLoss loss, double tukey) const;
  /// Robust standard deviation of the last evaluation's edge pixels, from this quantile (0.5 or 0.25) of |residual|; 0
  /// when there are fewer than 30.
  double spread(double quantile) const;
  /// The same of the picture's noise alone, from the steps between neighbours within cells; clipped ones tell nothing.
  double flatNoise() const;

  /// How much longer than its weighted least squares say a step should be, because weights change along it: mean weight
  /// over mean derivative of weight times residual.
  double stretch(double scale, RobustLoss loss, double tukey) const;

  /// The step that minimises the damped quadratic model, times `stretch`, applied to `state`; nothing when the
  /// equations are singular. `length`: its square in the metric of the normal equations [grey levels^2].
  std::optional<PhotometricState> step(const PhotometricState& state, double damping, double stretch,
                                       double& length) const;
  /// Inverse of the normal matrix's pose part, everything else marginalised [1/grey levels^2]; nothing when singular.
  std::optional<Matrix6d> inversePoseInformation() const;

  /// Sum of the squared differences of all grey levels from their marker's mean [grey levels^2].
  double greySquares() const;

  const std::vector<double>& residuals() const { return residuals_; }
  int unknowns() const;
  int edgePixels() const;
  int pixels() const;

 private:
  static constexpr int kLargest = 14;  // 6 + 3 + 4 unknowns and the residual
  using Block = Eigen::Matrix<double, kLargest, kLargest>;
  using Shared = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;
  using SharedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 9, 1>;

  template <int kBlur, int kBrightness>
  bool accumulate(std::size_t marker, const PhotometricState& state, double scale, RobustLoss loss, double tukey,
                  int stride);
  void toObject(std::size_t marker, const PhotometricState& state);
  Shared reduced(double damping, SharedVector& right) const;
  Eigen::MatrixXd brightnessInformation(std::size_t marker, double damping) const;

  const std::vector<PatternPlacement>& placements_;
  const std::vector<MarkerSamples>& samples_;
  int blur_, brightness_;
  ClipRange range_;
  double slope_damping_ = 0.0;     // [grey levels^2] added to the information on the slopes
  std::vector<Block> blocks_;      // per marker, upper triangle of [J r]^T W [J r]
  std::vector<double> residuals_;  // of the last evaluation; not a number where nothing can be told
  mutable std::vector<double> sorted_;
  std::vector<char> edge_;  // beside residuals_
};

}  // namespace seater_perception
