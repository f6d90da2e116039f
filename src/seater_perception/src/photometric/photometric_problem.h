#pragma once

#include <optional>
#include <vector>

#include "photometric/kernel/photometric_kernel.h"
#include "photometric/samples/photometric_samples.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// All unknowns of a photometric fit.
struct PhotometricState {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  SpreadCovariance blur;  ///< of the lens, pixel area not included; may be slightly negative
  std::vector<Brightness> brightness;
};

/// The least-squares problem: residuals, normal equations, steps. Unknowns: motion of the object (6, order and meaning
/// as in pose.h), blur (0, 1 or 3), brightness of each marker (2, 4 or 5), the latter eliminated marker by marker
/// (Schur complement). Holds memory that is used again: one problem for all fits of a thread.
class PhotometricProblem {
 public:
  enum class Blur { given = 0, round = 1, directed = 3 };

  /// Of these markers and pixels, which have to outlive it.
  void set(const CameraModel& camera, const std::vector<PatternPlacement>& placements,
           const std::vector<MarkerSamples>& samples, Blur blur, bool slopes);

  /// Brings a blur back to where the model holds for these pixels; true when it was not there.
  bool limitBlur(SpreadCovariance& blur) const;
  /// Offset and gain from the darkest and the lightest quarter of the pattern.
  void startBrightness(PhotometricState& state);

  /// Residuals and normal equations at a state, on this part of the pixels (1: all). False when the state is impossible
  /// (behind the camera, negative contrast).
  bool evaluate(const PhotometricState& state, const Weighing& weighing, double part = 1.0);
  /// Loss of the last evaluation's residuals, for another weighing. `part` counts from all pixels.
  LossSums loss(const Weighing& weighing, double part = 1.0) const;
  /// Robust standard deviation of the last evaluation's residuals, from this quantile (0.5 or 0.25) of |residual|; 0
  /// when there are fewer than 30.
  double spread(double quantile) const;
  /// The same of the image's noise alone, from the steps between neighbours within cells; clipped ones tell nothing.
  double flatNoise() const;
  /// Whether there are enough such steps.
  bool tellsNoise() const;

  /// The step that minimises the damped quadratic model, times `stretch`, applied to `state`; nothing when the
  /// equations are singular. `length`: its square in the metric of the normal equations [grey levels^2].
  std::optional<PhotometricState> step(const PhotometricState& state, double damping, double stretch,
                                       double& length) const;
  /// Squared distance of two poses in the metric of the last evaluation's normal equations, all else fitted to each
  /// [grey levels^2].
  double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;
  /// Inverse of the normal matrix's pose part, everything else marginalised [1/grey levels^2]; nothing when singular.
  std::optional<Matrix6d> inversePoseInformation() const;

  /// Sum of the squared differences of all grey levels from their marker's mean, and of all residuals; each pixel of a
  /// block counts [grey levels^2].
  double greySquares() const;
  double residualSquares() const;
  /// Share of the pixels up to, and from this grey level on.
  double shareBelow(double level) const;
  double shareAbove(double level) const;

  int unknowns() const;
  int pixels() const;

 private:
  using Block = Eigen::Matrix<double, kColumns, kColumns>;
  using Shared = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;
  using SharedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 9, 1>;
  using Own = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5>;

  bool evaluateMarker(std::size_t m, const PhotometricState& state, const Weighing& weighing, double part);
  void addBlocks(std::size_t m, const Brightness& brightness, const Weighing& weighing, double sum[kColumns][kColumns]);
  void toObject(std::size_t m, const PhotometricState& state);
  template <typename Is>
  double share(const Is& is) const;
  bool view(std::size_t m, const PhotometricState& state, MarkerView& view) const;
  SpreadCovariance blurAfter(SpreadCovariance blur, const SharedVector& change) const;
  Shared reduced(double damping, SharedVector& right) const;
  Own brightnessInformation(std::size_t m, double damping) const;

  const std::vector<PatternPlacement>* placements_ = nullptr;
  const std::vector<MarkerSamples>* samples_ = nullptr;
  double fx_ = 1.0, fy_ = 1.0;
  int blur_ = 0, brightness_ = 2;
  double slope_damping_ = 0.0;                         // [grey levels^2] added to the information on the slopes
  double rim_damping_ = 0.0;                           // the same on the rim
  double block_squares_ = 0.0;                         // of the blocks' residuals
  std::vector<Block> blocks_;                          // per marker, upper triangle of [J r]^T W [J r]
  std::vector<std::vector<float>> residuals_, valid_;  // per marker, of the last evaluation
  std::vector<int> evaluated_;                         // how many of them
  mutable std::vector<float> sorted_;
  std::vector<float> white_;
};

}  // namespace seater_perception
