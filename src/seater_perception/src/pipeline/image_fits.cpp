#include <algorithm>
#include <cmath>
#include <numeric>

#include "image/exposure.h"
#include "pipeline/detection_pipeline.h"

namespace seater_perception {
namespace {

// What fits leave unexplained with one exponent over that with none, from which on it is the camera's. Chosen by hand:
// photographs and drawn cameras with a tone curve show 0.05 to 0.7.
constexpr double kBetter = 0.75;
// Of the variance of grey levels: less is rounding; more has other causes (little white, test_little_white.py: 0.1 and
// more).
constexpr double kLeastLeftOver = 1e-4, kMostByTone = 0.1;
// [px] of a corner (MarkerFits::modelSigma): images drawn without a curve, whose edges their maker has softened
// otherwise, show 0.21 to 0.30 (published_images_test) and are better explained by light, which puts corners 0.4 px
// beside theirs.
constexpr double kLeastByTone = 0.32;
constexpr std::size_t kAsked = 6;  // markers of an image, which decide that

/// Of a marker's hypotheses, the one whose attitude is nearest to this pose's.
void keepNearest(const Eigen::Isometry3d& pose, MarkerEstimate& marker) {
  const auto turn = [&pose](const PoseHypothesis& h) { return turnBetween(h.pose, pose); };
  PoseHypothesis nearest = *std::min_element(marker.hypotheses.begin(), marker.hypotheses.end(),
                                             [&](const auto& a, const auto& b) { return turn(a) < turn(b); });
  nearest.weight = 1.0;
  marker.hypotheses = {nearest};
  marker.ambiguity = 0.0;
  marker.branch_known = true;
}

double leftOverOf(const RefinedMarker& refined) {
  return std::max(kLeastLeftOver, 1.0 - refined.explained);
}

/// Whether a fit to grey levels leaves as much as a tone curve does.
bool asksForTone(const RefinedMarker& refined) {
  return refined.marker.model_sigma > kLeastByTone && leftOverOf(refined) < kMostByTone;
}

}  // namespace

/// Where several markers together leave one pose of the dock only, each one's branch is known.
void DetectionPipeline::keepDecided(const std::vector<DockHypothesis>& dock, MarkerEstimate& marker) const {
  const auto place = layout_.markers.find(marker.image.id);
  if (place == layout_.markers.end() || dock.size() != 1 || dock.front().marker_ids.size() < 2) return;
  keepNearest(dock.front().pose * place->second.T_dock_marker(), marker);
}

/// A tracked marker that the fit does not confirm is done again from its edges.
DetectionPipeline::Fit DetectionPipeline::fit(const PhotometricContext& context,
                                              const std::vector<DockHypothesis>& dock, const MarkerEstimate& marker,
                                              bool tracked) const {
  Fit fit{marker, {}, tracked};
  keepDecided(dock, fit.found);
  fit.refined = refineMarker(context, fit.found, tracked);
  if (fit.refined.outcome != MarkerOutcome::doubtful) return fit;
  const bool of_this_image = startAgain(context.grey, fit.found);
  keepDecided(dock, fit.found);
  fit.refined = refineMarker(context, fit.found, false);
  fit.as_tracked = false;
  // Poses of the last image.
  if (fit.refined.outcome != MarkerOutcome::refined && !of_this_image) fit.refined.marker.hypotheses.clear();
  return fit;
}

/// From its corners, with edges; false, and nothing changed, when they give no pose.
bool DetectionPipeline::startAgain(const cv::Mat& grey, MarkerEstimate& marker) const {
  MarkerCorners corners = marker.image;
  corners.psf_sd = corners.edges_fitted ? corners.psf_sd : 0.0;
  if (!corners.edges_fitted) search_.refine(grey, corners);
  const auto again = estimateMarker(camera_, corners, marker.size, priorOf(corners.id), parameters_.pose);
  if (again) marker = *again;
  return again.has_value();
}

DetectionPipeline::ImageFits DetectionPipeline::fitsBy(const cv::Mat& grey, const Tone& tone, std::size_t count) {
  return {inLight(grey, tone.exponent), tone, std::vector<std::optional<Fit>>(count)};
}

PhotometricContext DetectionPipeline::contextOf(const ImageFits& image) {
  return {image.levels, camera_, parameters_.pose, refiner_, patterns_, image.tone.exponent};
}

/// What a fit to light begins with: edges lie elsewhere there.
MarkerEstimate DetectionPipeline::litMarker(const ImageFits& image, const MarkerEstimate& marker, bool tracked) const {
  MarkerEstimate lit = marker;
  const auto light = [&image](double grey) { return levelInLight(grey, image.tone.exponent); };
  lit.image.dark = light(marker.image.dark);
  if (marker.image.contrast > 0.0)
    lit.image.contrast = std::max(1.0, light(marker.image.dark + marker.image.contrast) - lit.image.dark);
  if (tracked || !marker.image.edges_fitted) return lit;
  search_.refine(image.levels, lit.image);
  return estimateMarker(camera_, lit.image, lit.size, priorOf(lit.image.id), parameters_.pose).value_or(lit);
}

void DetectionPipeline::fitMarker(const FitStart& start, std::size_t i, ImageFits& fits) {
  const MarkerEstimate& marker = start.markers[i];
  const bool tracked = start.tracked.count(marker.image.id) > 0;
  const MarkerEstimate begin = fits.tone.exponent == 1.0 ? marker : litMarker(fits, marker, tracked);
  fits.of[i] = fit(contextOf(fits), start.dock, begin, tracked);
}

/// Of the asked markers that are not as the model has them, what `other` leaves unexplained over what `first` does:
/// the geometric mean, large markers count more.
double DetectionPipeline::leftOver(const FitStart& start, const std::vector<std::size_t>& asked, ImageFits& first,
                                   ImageFits& other) {
  double change = 0.0, area = 0.0;
  for (const std::size_t i : asked) {
    const RefinedMarker& by_first = first.of[i]->refined;
    if (!asksForTone(by_first)) continue;
    if (!other.of[i]) fitMarker(start, i, other);
    const double side = start.markers[i].image.side();
    change += side * side * std::log(leftOverOf(other.of[i]->refined) / leftOverOf(by_first));
    area += side * side;
  }
  return area > 0.0 ? std::exp(change / area) : 1.0;
}

/// By the exponent that explains most of the largest markers: one camera has made all of the image.
DetectionPipeline::ImageFits DetectionPipeline::bestTone(const cv::Mat& grey, const FitStart& start) {
  const std::size_t count = start.markers.size();
  std::vector<std::size_t> asked(count);
  std::iota(asked.begin(), asked.end(), 0);
  std::stable_sort(asked.begin(), asked.end(), [&start](std::size_t a, std::size_t b) {
    return start.markers[a].image.side() > start.markers[b].image.side();
  });
  asked.resize(std::min(count, kAsked));
  ImageFits by_grey = fitsBy(grey, {}, count), best;
  for (const std::size_t i : asked) fitMarker(start, i, by_grey);
  const auto asks = [&by_grey](std::size_t i) { return asksForTone(by_grey.of[i]->refined); };
  if (std::none_of(asked.begin(), asked.end(), asks)) return by_grey;
  double least = kBetter;
  for (const double exponent : kToneExponents) {
    ImageFits fits = fitsBy(grey, {exponent, 0.0}, count);
    const double left = leftOver(start, asked, by_grey, fits);
    if (left < least) least = left, best = std::move(fits);
    if (!(left < 1.0)) break;  // more of it would be worse
  }
  if (best.of.empty()) return by_grey;
  best.tone.shift_sigma = shiftSigma(by_grey, nullptr);
  return best;
}

/// By the tone that is known, or the one that explains most.
DetectionPipeline::ImageFits DetectionPipeline::fitImage(const cv::Mat& grey, const std::optional<Tone>& tone,
                                                         const FitStart& start) {
  ImageFits fits = tone ? fitsBy(grey, *tone, start.markers.size()) : bestTone(grey, start);
  for (std::size_t i = 0; i < fits.of.size(); ++i) {
    if (!fits.of[i]) fitMarker(start, i, fits);
    keepGrey(grey, start, i, fits);
  }
  return fits;
}

/// A marker that has no fit in light (too dark in its part of the image) but one in grey levels: that, of which the
/// dock's joint fit takes the corners only.
void DetectionPipeline::keepGrey(const cv::Mat& grey, const FitStart& start, std::size_t i, ImageFits& fits) {
  if (fits.tone.exponent == 1.0 || fits.of[i]->refined.outcome == MarkerOutcome::refined) return;
  ImageFits by_grey = fitsBy(grey, {}, fits.of.size());
  fitMarker(start, i, by_grey);
  if (by_grey.of[i]->refined.outcome != MarkerOutcome::refined) return;
  fits.of[i] = by_grey.of[i];
  fits.of[i]->refined.marker.model_holds = false;
}

}  // namespace seater_perception
