#pragma once

#include <optional>
#include <vector>

#include "photometric/evaluation.h"
#include "photometric/samples/photometric_samples.h"
#include "seater_perception/camera_model.h"

namespace seater_perception {

/// How the fit treats the lens' point spread function; the value is its number of unknowns.
enum class PsfModel {
  given = 0,       ///< as the parameters say
  isotropic = 1,   ///< one variance, estimated
  anisotropic = 3  ///< a covariance, estimated: motion blur has a direction
};

/// The least-squares problem of some markers and pixels. Unknowns: motion of the object (6, order and meaning as of
/// PoseHypothesis::covariance), point spread function (PsfModel), brightness of each marker (2: offset, gain; 4: and
/// slopes; 5: and rim), the latter eliminated marker by marker (Schur complement).
class PhotometricProblem {
 public:
  /// All but the camera have to outlive it. `slopes`: of brightness, and a rim where samples see one, are unknowns too.
  PhotometricProblem(const CameraModel& camera, const std::vector<PatternPlacement>& placements,
                     const std::vector<MarkerSamples>& samples, PsfModel psf, bool slopes, EvaluationPool& pool);

  /// Residuals and normal equations at a state, on this part of the pixels (1: all). Nothing when the state is
  /// impossible (behind the camera, negative contrast).
  std::optional<Evaluation> evaluate(const PhotometricState& state, const Weighing& weighing, double part = 1.0) const;

  /// Brings a point spread function back to where the model holds for these pixels; true when it was not there.
  bool limitPsf(SpreadCovariance& psf) const;
  /// Offset and gain of each marker from the darkest and the lightest quarter of its pattern.
  std::vector<Brightness> initialBrightness(const PhotometricState& state) const;
  /// Robust standard deviation of the image's noise alone, from the steps between neighbours within cells; clipped ones
  /// tell nothing. 0 when there are too few such steps.
  double flatNoise() const;
  /// Whether there are enough such steps.
  bool tellsNoise() const;
  /// Fraction of the pixels up to, and from this grey level on.
  double fractionBelow(double level) const;
  double fractionAbove(double level) const;

  /// Rows of a marker's least-squares problem, each weighted by the root of its pixel's weight.
  struct WeightedRows {
    Eigen::MatrixXf rows;  ///< [J r] of accumulateBatch, motion along the marker's own axes
    Eigen::Matrix<double, kColumns, kColumns> products;  ///< upper triangle of [J r]^T [J r]
  };
  /// Of the first `most` pixels of the first marker; nothing when the state is impossible.
  std::optional<WeightedRows> weightedRows(const PhotometricState& state, const Weighing& weighing, int most) const;
  /// Derivative of the pixel by the place on the first marker, about its middle [px per cell].
  Eigen::Matrix2d pixelByCell(const PhotometricState& state) const;

  const std::vector<MarkerSamples>& samples() const { return *samples_; }
  int psfUnknowns() const { return psf_; }
  int brightnessUnknowns() const { return brightness_; }
  int unknowns() const;
  int pixels() const;
  /// Of the first marker along a side, the border included.
  int cells() const { return placements_->front().pattern.cells(); }

 private:
  using Buffers = EvaluationPool::Buffers;

  bool evaluateMarker(std::size_t m, const Weighing& weighing, double part, Buffers& out) const;
  void addBlocks(std::size_t m, const Brightness& brightness, const Weighing& weighing, double sum[kColumns][kColumns],
                 Buffers& out) const;
  void toObject(std::size_t m, Buffers& out) const;
  template <typename Is>
  double fraction(const Is& is) const;
  bool view(std::size_t m, const PhotometricState& state, MarkerView& view) const;

  const std::vector<PatternPlacement>* placements_;
  const std::vector<MarkerSamples>* samples_;
  EvaluationPool* pool_;
  double fx_, fy_;
  int psf_, brightness_;
};

}  // namespace seater_perception
