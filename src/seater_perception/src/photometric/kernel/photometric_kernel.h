#pragma once

#include <Eigen/Geometry>

#include "marker/marker_plane.h"
#include "numerics/robust_loss.h"
#include "photometric/samples/photometric_batch.h"
#include "seater_perception/marker_pattern.h"

namespace seater_perception {

/// A marker as the kernel sees it, lengths in cells, everything about the middle ray of its pixels.
struct MarkerView {
  float along[3], x[3], y[3], alpha[3], beta[3];  ///< numerators and the common denominator: constant, by x, by y
  float r1x, r1y, r2x, r2y, r3x, r3y;             ///< of the marker's axes, per pixel
  float half_sheet;                               ///< half the side of print and quiet zone [cells]
  float depth, inverse_depth;                     ///< of the plane along its normal [cells]
  SpreadCovariance spread;                        ///< what a ray sees of the image, pixel area included [px^2]
  int rays = 1;                                   ///< per pixel

  /// `pose` in the optical frame. False when a pixel of the batch would not see the marker's front.
  static bool make(const Eigen::Isometry3d& pose, double per_metre, double half_sheet, double fx, double fy,
                   const SpreadCovariance& spread, const MarkerSamples& samples, MarkerView& view);
};

/// Largest number of columns of the normal equations: 6 of motion, 3 of the PSF (point spread function), 5 of
/// brightness, the residual.
constexpr int kColumns = 15;

/// How residuals are weighed.
struct Weighing {
  double scale = 1.0;  ///< noise the loss is measured with [grey levels]
  RobustLoss loss = RobustLoss::huber;
  double tukey = 6.0;  ///< limit of Tukey's loss in scales
  ClipRange range;
};

/// Residuals (`residual`, and `valid` 1, or 0 for a pixel whose clipping hides everything) of the first `count` pixels,
/// and the upper triangle of [J r]^T W [J r], added to `sum`. Columns: motion of the marker (translation [cells] and
/// rotation [rad] along its own axes: t' = t + R d, R' = R exp([w]x)), PSF (0: none, 1: variance of a round one, 3:
/// variances uu, uv, vv [px^2]), brightness (2: offset, gain; 4: and slopes; 5: and rim), residual. How
/// the rim changes with motion and PSF is left out: where a sheet ends is not to tell the pose. `rows`, where given:
/// the columns of W^(1/2) [J r], of `count` floats each.
void accumulateBatch(const PixelBatch& batch, int count, const MarkerView& view, int psf, int brightness_unknowns,
                     const Brightness& brightness, const Weighing& weighing, double sum[kColumns][kColumns],
                     float* residual, float* valid, float* rows = nullptr);

/// White (0 to 1) of the first `count` pixels.
void whiteOfBatch(const PixelBatch& batch, int count, const MarkerView& view, float* white);

/// For tests: white and its derivatives (6 + psf rows of `stride` floats) of all pixels.
void renderBatch(const PixelBatch& batch, const MarkerView& view, int psf, float* white, float* by, int stride);

}  // namespace seater_perception
