#include "pose/marker_pose.h"

#include <algorithm>

#include "seater_perception/dock_layout.h"

namespace seater_perception {

std::optional<Correspondences> markerCorrespondences(const CameraModel& camera, const MarkerCorners& marker,
                                                     double size, const PoseParameters& parameters) {
  Correspondences points;
  const double usual = marker.edges_fitted ? parameters.corner_sigma : parameters.corner_sigma_coarse;
  const double sigma = marker.corner_sigma > 0.0 ? marker.corner_sigma : usual;
  const auto corners = markerCorners(size);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!points.add(corners[i], marker.corners[i], sigma, camera)) return std::nullopt;
  }
  return points;
}

std::optional<MarkerEstimate> estimateMarker(const CameraModel& camera, const MarkerCorners& marker, double size,
                                             const PosePrior& prior, const PoseParameters& parameters) {
  const auto points = markerCorrespondences(camera, marker, size, parameters);
  if (!points) return std::nullopt;
  MarkerEstimate result;
  result.image = marker;
  result.size = size;
  result.stage = marker.edges_fitted ? PoseStage::edges : PoseStage::corners;
  result.hypotheses = refineAll(camera, *points, squareSolutions(*points));
  weigh(result.hypotheses, points->size(), prior, parameters.tilt_sigma);
  if (result.hypotheses.empty()) return std::nullopt;
  if (result.best().error > largestError(marker.side(), parameters)) return std::nullopt;
  double smallest = result.best().chi_squared;
  for (const PoseHypothesis& h : result.hypotheses) smallest = std::min(smallest, h.chi_squared);
  result.ambiguity = ambiguity(result.hypotheses, inflation(smallest, points->size()));
  return result;
}

}  // namespace seater_perception
