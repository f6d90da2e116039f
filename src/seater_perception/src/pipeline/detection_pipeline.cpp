#include "pipeline/detection_pipeline.h"

#include <algorithm>
#include <cmath>

#include "image/exposure.h"
#include "image/image_checks.h"
#include "pipeline/expected_marker.h"
#include "pose/shift_field.h"
#include "stage/initial_poses.h"
#include "stage/open_branches.h"

namespace seater_perception {

namespace {

constexpr double kQuietZone = 0.15;  // [sides] round a marker: about a cell
// What all other markers of the image tell of its shifts counts as that of so many at most: prints are bent one by one.
constexpr double kOthers = 8.0;
constexpr double kLeastShift = 0.02;  // [px] No lens is calibrated better, however little of it a marker shows.
// [px] Shifts below these are not known to turn a branch over; by the wrong branches on drawn kinds of cameras.
constexpr double kSmallShift = 0.025;

/// Only what is not in the layout can be left out of the search.
std::set<int> idsOf(const DockLayout& layout) {
  std::set<int> ids;
  if (layout.size_of_others) return ids;
  for (const auto& [id, marker] : layout.markers) ids.insert(id);
  return ids;
}

}  // namespace

DetectionResult resultOf(const ImageEstimate& estimate, bool full_search) {
  DetectionResult result;
  for (const MarkerEstimate& m : estimate.markers) {
    result.markers.push_back({m.image.id, m.size, m.image.corners, m.image.side(), m.image.edges_fitted, m.hypotheses,
                              m.ambiguity, m.stage, m.white_cut_off});
  }
  result.dock = estimate.dock;
  result.refused = estimate.refused;
  result.full_search = full_search;
  return result;
}

DetectionPipeline::DetectionPipeline(const CameraModel& camera, const DockLayout& layout,
                                     const PerceptionParameters& parameters, const CameraMount& mount)
    : camera_(camera),
      layout_(layout),
      parameters_(parameters),
      up_(mount.upInOptical()),
      search_(layout.family, parameters.detector, idsOf(layout)),
      refiner_(parameters.photometric),
      patterns_(layout.family) {}

/// Nothing when the fit has to begin with the corners.
std::optional<MarkerEstimate> DetectionPipeline::expected(const MarkerCorners& found,
                                                          const std::map<int, MarkerEstimate>& last) const {
  const auto known = last.find(found.id);
  if (known == last.end() || parameters_.refinement != "photometric") return std::nullopt;
  auto marker = expectedMarker(camera_, known->second, found);
  const bool usable = marker && marker->image.psf_sd > 0.0 && marker->image.contrast > 0.0;
  return usable ? marker : std::nullopt;
}

ImageEstimate DetectionPipeline::evaluate(const SearchResult& found, const std::map<int, MarkerEstimate>& last,
                                          const std::optional<Tone>& tone) {
  const cv::Mat& grey = found.lit;
  checkImage(grey, camera_);
  ImageEstimate result;
  std::set<int> tracked;
  for (const MarkerCorners& corners : found.markers) {
    const auto size = layout_.sizeOf(corners.id);
    if (!size) continue;
    auto marker = expected(corners, last);
    if (marker) tracked.insert(corners.id);
    if (!marker) marker = estimateMarker(camera_, corners, *size, priorOf(corners.id), parameters_.pose);
    if (marker) {
      result.markers.push_back(*marker);
    } else {
      ++result.refused;
    }
  }
  const bool photometric = parameters_.refinement == "photometric";
  ImageFits image;
  if (photometric) image = refineMarkers(grey, tone, tracked, result);
  for (MarkerEstimate& marker : result.markers) {
    const Eigen::AlignedBox2d box = boundingBox(marker.image.corners);
    const Eigen::Vector2d margin = kQuietZone * box.sizes();
    marker.white_cut_off = whiteCutOff(grey, {box.min() - margin, box.max() + margin});
  }
  result.dock = estimateDock(camera_, result.markers, layout_, parameters_.selection, up_, parameters_.pose);
  if (photometric) {
    result.dock = refineDock(contextOf(image), layout_, up_, result.markers, result.dock).dock;
  }
  addPlacementError(camera_, layout_, parameters_.pose.placement_sigma, result.dock);
  return result;
}

PosePrior DetectionPipeline::priorOf(int id) const {
  PosePrior prior;
  // Only the dock's own markers are known to stand upright.
  if (layout_.markers.count(id)) prior.up = up_;
  return prior;
}

/// [px] Of the image's shifts at a marker: by what its own fit has left over, and the others', and how far its
/// outline is from its own fit. Of none: all alike.
double DetectionPipeline::shiftSigma(const ImageFits& image, const Fit* of) const {
  const double usual = parameters_.pose.model_sigma;
  if (usual == 0.0 && of && !of->refined.deviates) return 0.0;
  ShiftField field;
  const double count = static_cast<double>(image.of.size());
  const double others = std::min(1.0, kOthers / std::max(1.0, of ? count - 1.0 : count));
  for (const auto& f : image.of) {
    if (!f || f->refined.outcome != MarkerOutcome::refined) continue;
    const ShiftEvidence& seen = f->refined.shifts;
    const double weight = of == &*f ? 1.0 : others;
    for (std::size_t k = 0; k < seen.square.size(); ++k) field.add(seen.information[k], seen.square[k], weight);
  }
  const double smooth = std::hypot(usual > 0.0 ? kLeastShift : 0.0, std::sqrt(field.variance(usual)));
  return std::max({image.tone.shift_sigma, of ? of->refined.outline_apart : 0.0, smooth});
}

MarkerEstimate DetectionPipeline::settled(const PhotometricContext& context, const std::vector<DockHypothesis>& dock,
                                          double shift_sigma, const Fit& fit) const {
  MarkerEstimate marker = fit.refined.marker;
  if (marker.hypotheses.empty()) return marker;
  if (fit.refined.outcome != MarkerOutcome::refined) {
    keepCorners(dock, marker);
    return marker;
  }
  settleMarker(context, priorOf(marker.image.id), shift_sigma, marker);
  const bool open = fit.refined.deviates || shift_sigma > kSmallShift;
  if (open && !fit.as_tracked && marker.ambiguity < kUndecided) leaveOpen(dock, fit.found, marker);
  return marker;
}

DetectionPipeline::ImageFits DetectionPipeline::refineMarkers(const cv::Mat& grey, const std::optional<Tone>& tone,
                                                              const std::set<int>& tracked, ImageEstimate& result) {
  const auto dock = estimateDock(camera_, result.markers, layout_, "bundle", up_, parameters_.pose);
  const ImageFits image = fitImage(grey, tone, {result.markers, tracked, dock});
  result.tone = image.tone;
  result.markers.clear();
  for (const auto& fit : image.of) {
    const MarkerEstimate marker = settled(contextOf(image), dock, shiftSigma(image, &*fit), *fit);
    // Its bits have proved the marker. That the grey levels are not as the model has them does not unmake it.
    if (marker.hypotheses.empty() || marker.image.side() < parameters_.detector.min_side) {
      ++result.refused;
    } else {
      result.markers.push_back(marker);
    }
  }
  return image;
}

/// Poses of the corners, when they give one.
void DetectionPipeline::keepCorners(const std::vector<DockHypothesis>& dock, MarkerEstimate& marker) const {
  const auto again = cornersEstimate(camera_, marker, priorOf(marker.image.id), parameters_.pose);
  if (!again) return;
  marker = *again;
  keepDecided(dock, marker);
}

/// Of residuals that are not noise alone, the branch that the corners leave open. `found`: with its corners.
void DetectionPipeline::leaveOpen(const std::vector<DockHypothesis>& dock, const MarkerEstimate& found,
                                  MarkerEstimate& refined) const {
  const bool small = found.image.side() < kLargeMarker;
  if (!small && found.image.edges_fitted && refined.model_holds) return;
  MarkerEstimate by_corners = found;
  by_corners.model_sigma = std::max(refined.model_sigma, refined.shift_sigma);
  keepCorners(dock, by_corners);
  openBranches(by_corners, refined);
}

}  // namespace seater_perception
