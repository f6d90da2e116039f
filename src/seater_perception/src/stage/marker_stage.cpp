#include "stage/marker_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pose/shift_field.h"
#include "seater_perception/dock_layout.h"
#include "stage/fitted_hypotheses.h"
#include "stage/initial_poses.h"
#include "stage/marker_fits.h"

namespace seater_perception {
namespace {

// Residuals at edges over those of flat pixels: from here on, the image is not what the model says
// (docs/explanation/perception.md).
constexpr double kMisfit = 1.8;
// Residuals of the outer edges about their own steps over those of the whole print. Drawings whose cells are off their
// places by rounding have at most 0.1, three of five tags of the published images (perception_accuracy) 0.3
// to 0.4, of the photographs' markers from 30 px on 95 % more than 0.54.
constexpr double kClean = 0.4;
constexpr double kCoarseCorners = 0.25;  // [cells] error of corners that no edge confirms
constexpr double kUnknown = 1.5;  // of corner_sigma_coarse: the same where no fit says anything (binarised images)
constexpr double kBlurredCorners = 0.25;  // [standard deviations of the PSF] the same of blurred edges
// [px] of a corner: what taking away a shadow's edge leaves; by the normalised errors of `perception_shadows`.
constexpr double kShadowSigma = 0.06;

/// Corners as the pose has them, with their own standard deviation.
void placeCorners(const CameraModel& camera, const PoseHypothesis& hypothesis, double smallest_sigma,
                  MarkerEstimate& marker) {
  std::array<Eigen::Vector2d, 4> corners;
  double variance = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d arm = hypothesis.pose.linear() * markerCorners(marker.size)[i];
    const Eigen::Vector3d point = arm + hypothesis.pose.translation();
    const auto pixel = camera.project(point);
    if (!pixel) return;
    corners[i] = *pixel;
    const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, point);
    variance += (J * hypothesis.covariance * J.transpose()).trace() / 8.0;
  }
  marker.image.corners = corners;
  marker.image.corner_sigma = std::max(smallest_sigma, std::sqrt(variance));
}

/// Leaves out what says nothing and what the corners contradict. False when the corners cannot be undistorted.
bool compareWithCorners(const PhotometricContext& context, const MarkerEstimate& marker, int cells, double doubt,
                        std::vector<PoseHypothesis>& hypotheses) {
  Correspondences seen;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!seen.add(markerCorners(marker.size)[i], marker.image.corners[i], 1.0, context.camera)) return false;
  }
  if (marker.image.shadow || marker.image.glare) addModelError(context.camera, seen, kShadowSigma, hypotheses);
  // Residuals that are not noise are alike from pixel to pixel: they prove as much less as they are larger.
  for (auto& h : hypotheses) h.chi_squared /= doubt;
  for (auto& h : hypotheses) h.error = reprojectionError(context.camera, seen, h.pose);
  // Corners that no edge confirms may be some tenths of a cell off, those of blurred edges a part of the PSF.
  const double side = marker.image.side();
  const double coarse =
      marker.image.edges_fitted ? kBlurredCorners * marker.image.psf_sd : kCoarseCorners * side / cells;
  const double limit = largestError(side, context.pose) + coarse;
  const auto unbelievable = [&](const PoseHypothesis& h) { return !meaningful(h) || h.error > limit; };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), unbelievable), hypotheses.end());
  return true;
}

/// How far a print's outline is from where the whole print has it (RefinedMarker::outline_apart). Smooth shifts leave
/// both together. White that has grown inside only, or edges that are steps, do not, and a whole print's pose hides it.
/// Which of both is right is not in the image. The outline tells nothing where a shadow crosses it, or where white is
/// cut off and has grown into all of it (by 0.5 px).
double outlineApart(const MarkerCorners& marker, bool grown, const std::vector<PoseHypothesis>& hypotheses) {
  if (!marker.edges_fitted || marker.shadow || marker.glare || grown) return 0.0;
  const auto nearer = [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.error < b.error; };
  return std::min_element(hypotheses.begin(), hypotheses.end(), nearer)->error / std::sqrt(2.0);
}

/// Where the image is not as the model has it: a clean outline is what the print's size means (cells may have uneven
/// widths), and any outline where the whole print could not be fitted; but not where a shadow's edge crosses it.
/// `residual` of the whole print [grey levels]; 0: not fitted.
bool outlineDecides(const MarkerCorners& marker, double residual) {
  if (!marker.edges_fitted || marker.shadow || marker.glare) return false;
  return !(residual > 0.0) || marker.edge_residual < kClean * residual;
}

struct Fitted {
  std::vector<PoseHypothesis> hypotheses;
  bool whole = false;  ///< of all residuals
};

/// Where the edges already show that the camera is not as modelled, the print as a whole at once; else after a fit that
/// leaves outliers out.
Fitted fitted(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked, MarkerFits& fits) {
  const bool unlike = !tracked && fits.unlikeModel(kMisfit);
  Fitted result;
  if (unlike) result.hypotheses = fits.fitWhole(context.refiner);
  result.whole = !result.hypotheses.empty() && fits.misfit() > kMisfit;
  if (result.whole) return result;
  const double psf_sd = marker.image.edges_fitted || tracked ? marker.image.psf_sd : 0.0;
  result.hypotheses = fits.fit(context.refiner, psf_sd);
  if (tracked || unlike || !(result.hypotheses.empty() || fits.misfit() > kMisfit)) return result;
  auto whole = fits.fitWhole(context.refiner);
  result.whole = !whole.empty();
  if (result.whole) result.hypotheses = std::move(whole);
  return result;
}

/// Where nothing has converged yet.
std::vector<PoseHypothesis> fittedCarefully(const PhotometricContext& context, const MarkerEstimate& marker,
                                            MarkerFits& fits) {
  const double psf_sd = marker.image.edges_fitted ? marker.image.psf_sd : 0.0;
  std::vector<PoseHypothesis> hypotheses;
  if (psf_sd > 0.0) hypotheses = fits.fit(context.refiner, 0.0);
  if (!hypotheses.empty() || marker.image.side() <= kLargeMarker) return hypotheses;
  // The quiet zone may be darker than the print's white (cut close and pasted on a wall): the print alone, then.
  PhotometricParameters print_only = context.refiner.parameters();
  print_only.quiet_zone = 0.0;
  PhotometricRefiner refiner(print_only);
  return fits.fit(refiner, psf_sd);
}

}  // namespace

RefinedMarker refineMarker(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked) {
  MarkerFits fits(context, marker, tracked);
  auto [hypotheses, whole] = fitted(context, marker, tracked, fits);
  if (tracked && (hypotheses.empty() || fits.misfit() > kMisfit))
    return {MarkerOutcome::doubtful, marker, true, {}, 0.0};
  if (hypotheses.empty()) hypotheses = fittedCarefully(context, marker, fits);
  RefinedMarker refined{
      MarkerOutcome::corners_kept, marker, fits.modelSigma() > 0.0, fits.shifts(), fits.explained(), 0.0};
  // Of fits that failed, residuals say little, but corners are not as far off as any part of a cell.
  const double coarse = context.pose.corner_sigma_coarse;
  const double shown = std::min(fits.modelSigma(), kCoarseCorners * marker.image.side() / fits.cells());
  refined.marker.model_sigma = fits.modelSigma();
  if (hypotheses.empty()) refined.marker.model_sigma = shown > 0.0 ? std::max(coarse, shown) : kUnknown * coarse;
  if (hypotheses.empty() || !compareWithCorners(context, marker, fits.cells(), fits.doubt(), hypotheses) ||
      hypotheses.empty())
    return refined;
  if (fits.misfit() > kMisfit && outlineDecides(marker.image, whole ? fits.residual() : 0.0)) {
    refined.marker.model_sigma = shown;
    return refined;
  }
  if (refined.deviates) refined.outline_apart = outlineApart(marker.image, fits.whiteCutOff(), hypotheses);
  refined.marker.model_holds = !(fits.misfit() > kMisfit);
  refined.outcome = MarkerOutcome::refined;
  refined.marker.stage = PoseStage::photometric;
  refined.marker.hypotheses = hypotheses;
  refined.marker.image.psf_sd = fits.psfSd();
  return refined;
}

void settleMarker(const PhotometricContext& context, const PosePrior& prior, double shift_sigma,
                  MarkerEstimate& marker) {
  auto& hypotheses = marker.hypotheses;
  marker.shift_sigma = shift_sigma;
  ShiftedPlaces places;
  places.add(marker.size, Eigen::Isometry3d::Identity(), shift_sigma);
  for (auto& h : hypotheses) {
    if (const auto covariance = shiftCovariance(context.camera, places, h.pose)) h.covariance += *covariance;
  }
  const auto unknown = [](const PoseHypothesis& h) { return !meaningful(h); };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), unknown), hypotheses.end());
  if (hypotheses.empty()) return;
  weighByPrior(hypotheses, prior, context.pose.tilt_sigma);
  placeCorners(context.camera, hypotheses.front(), context.pose.corner_sigma, marker);
  marker.ambiguity = ambiguity(hypotheses, 1.0);
}

}  // namespace seater_perception
