#include "stage/marker_fits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "image/exposure.h"
#include "image/image_noise.h"
#include "stage/fitted_hypotheses.h"
#include "stage/initial_poses.h"

namespace seater_perception {
namespace {

// Chosen by hand where no reason is given; detection_test, plain_markers_test, tracker_cases_test and
// test_camera_kinds notice.
constexpr double kBeyondScale = 0.15;  // [ranges of grey levels] how far black and white may lie beyond the sensor's
constexpr double kClipped = 0.05;     // fraction of the pixels at an end, from which on white or black may lie anywhere
constexpr double kLargestPsf = 0.95;  // [cells] standard deviation; wider, cells cannot be told apart
// Residuals at edges over those of flat pixels, from which on the deviation counts.
constexpr double kNoticed = 1.35;
// [pixels] that err together where residuals are not noise; by the wrong branches on nine kinds of cameras.
constexpr double kAlike = 12.0;
constexpr double kBeside = 0.5;      // [sides] round a marker, where its surroundings tell the noise
constexpr double kLeastNoise = 0.5;  // [grey levels] of rounding and a little more
// Root mean square slope of a blurred step within 2.5 standard deviations of it, times its width over its height:
// sqrt(1 / (2 sqrt(pi)) / 5). Residuals over it are how far the edge is from where the model has it.
constexpr double kMeanSlope = 0.2375;
// How much larger the error of a corner is than what the residuals show of it: shifts that are the same over 8 to 20 px
// are mostly followed by the fit. By the normalised errors of test_camera_kinds.
constexpr double kHiddenShift = 2.5;
// [px] of a corner where the paper is cut off at the end of the range: how much lighter it is, and how far its light
// has grown into the ink, is not in the image. Edges of over-exposed photographs lie 0.2 to 0.6 px inwards.
constexpr double kBloom = 0.3, kMuchClipped = 0.3;

/// Grey levels that the sensor could have seen, and a point spread function that leaves cells distinct.
bool plausible(const PhotometricResult& result, double side, int cells, double full_scale, double exponent) {
  // Where the image is clipped, the sensor does not know how dark or light it would have been.
  const auto beyond = [full_scale](double clipped) { return (clipped > kClipped ? 1.0 : kBeyondScale) * full_scale; };
  const double least = -beyond(result.clipped_low),
               most = full_scale * lightOf(1.0 + beyond(result.clipped_high) / full_scale, exponent);
  for (const Brightness& b : result.brightness) {
    if (b.used && (b.offset < least || b.offset + b.gain > most)) return false;
  }
  return result.psf_sd < kLargestPsf * side / cells;
}

/// What covers a part of a print is left out of the fit. Where all four edges show, or the code without anything left
/// out, nothing does: then outliers are what the camera has made of edges. What a shadow's edge has left is in neither.
bool wholePrint(const MarkerCorners& marker) {
  return !marker.shadow && !marker.glare && (marker.edges_fitted || marker.contrast > 0.0);
}

double shiftOf(const PhotometricResult& result, double residual, double misfit) {
  if (!(misfit > kNoticed)) return 0.0;
  const double excess = std::sqrt(1.0 - 1.0 / (misfit * misfit)) * residual;
  const double width = std::sqrt(result.psf_sd * result.psf_sd + 1.0 / 12.0);  // with the pixel's own area
  return kHiddenShift * excess * width / (kMeanSlope * std::max(1.0, result.brightness.front().gain));
}

double bloomOf(const PhotometricResult& result) {
  const double part = (result.clipped_high - kClipped) / (kMuchClipped - kClipped);
  return kBloom * std::clamp(part, 0.0, 1.0);
}

}  // namespace

MarkerFits::MarkerFits(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked)
    : context_(context),
      marker_(marker),
      placement_{{context.patterns.of(marker.image.id), marker.size, Eigen::Isometry3d::Identity()}},
      cells_(placement_.front().pattern.cells()) {
  if (tracked) brightness_ = Brightness{true, marker.image.dark, marker.image.contrast, 0.0, 0.0, 0.0};
}

std::vector<PoseHypothesis> MarkerFits::fit(PhotometricRefiner& by, double psf_sd) {
  auto found = fitFrom(by, openPoses(marker_), {psf_sd, brightness_});
  if (!otherBranchOpen(marker_, branches_, found)) return found;
  const double near = psf_sd > 0.0 ? psf_sd : by.parameters().psf_sd;
  const auto both = fitFrom(by, steepPoses(found.front().pose), {near, std::nullopt});
  return both.empty() ? found : both;
}

std::vector<PoseHypothesis> MarkerFits::fitWhole(PhotometricRefiner& by) {
  if (!wholePrint(marker_.image)) return {};
  // Not that of the edges: from the very sharp ones of aliased images, fits often do not converge.
  const double psf_sd = psf_sd_ > 0.0 ? psf_sd_ : by.parameters().psf_sd;
  return fitFrom(by, openPoses(marker_), {psf_sd, std::nullopt, true});
}

std::vector<PoseHypothesis> MarkerFits::fitFrom(PhotometricRefiner& by, const std::vector<Eigen::Isometry3d>& initial,
                                                const PhotometricStart& start) {
  branches_ = by.refineBranches(context_.grey, context_.camera, placement_, initial, start);
  const double side = marker_.image.side(), full_scale = context_.grey.depth() == CV_16U ? 65535.0 : 255.0;
  double best = std::numeric_limits<double>::infinity();
  for (auto& b : branches_) {
    b.result.converged = b.result.converged && plausible(b.result, side, cells_, full_scale, context_.exponent);
    if (!b.result.converged || b.chi_square >= best) continue;
    best = b.chi_square;
    compareWithNoise(b.result);
  }
  // The bits have proved what nothing covers; what is left over is the camera's.
  return distinct(branches_, start.whole ? kExplainedLarge : smallestExplained());
}

void MarkerFits::compareWithNoise(const PhotometricResult& result) {
  const double residual = wholePrint(marker_.image) ? result.rms : result.noise_sd;
  residual_ = residual;
  misfit_ = residual / noiseBeside(result);
  psf_sd_ = result.psf_sd;
  shifts_ = result.shifts;
  explained_ = result.explained;
  white_cut_off_ = result.clipped_high > kClipped;
  model_sigma_ = std::hypot(shiftOf(result, residual, misfit_), bloomOf(result));
  // Curves of grey levels (equalised, binarised images) leave residuals that say little of places.
  if (result.explained < smallestExplained()) model_sigma_ = std::max(model_sigma_, context_.pose.corner_sigma_coarse);
}

double MarkerFits::smallestExplained() const {
  return marker_.image.side() < kLargeMarker ? kExplainedSmall : kExplainedLarge;
}

/// [grey levels] of flat pixels of the print, or what its surroundings show, where that is less or the print has
/// none. A shadow's edge makes flat pixels uneven too, and is no fault of the model.
double MarkerFits::noiseBeside(const PhotometricResult& result) {
  const bool clipped = std::max(result.clipped_low, result.clipped_high) > kClipped;  // and with it its noise
  if (result.flat_noise > 0.0 && (marker_.image.shadow || marker_.image.glare)) return result.flat_noise;
  return result.flat_noise > 0.0 && !clipped ? std::min(result.flat_noise, noiseRound()) : noiseRound();
}

bool MarkerFits::unlikeModel(double misfit) {
  if (!wholePrint(marker_.image)) return false;
  return !marker_.image.edges_fitted || marker_.image.edge_residual > misfit * noiseRound();
}

double MarkerFits::noiseRound() {
  if (!(beside_ > 0.0)) {
    const Eigen::AlignedBox2d box = boundingBox(marker_.image.corners);
    const Eigen::Vector2d margin = kBeside * box.sizes();
    beside_ = std::max(kLeastNoise, whiteNoise(context_.grey, {box.min() - margin, box.max() + margin}));
  }
  return beside_;
}

double MarkerFits::doubt() const {
  return model_sigma_ > 0.0 ? kAlike * std::max(1.0, misfit_ * misfit_) : 1.0;
}

}  // namespace seater_perception
