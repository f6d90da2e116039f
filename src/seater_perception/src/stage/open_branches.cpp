#include "stage/open_branches.h"

#include <algorithm>
#include <cmath>

#include "stage/initial_poses.h"

namespace seater_perception {
namespace {

constexpr double kLongTails = 2.0;   // of the corners' standard deviation
constexpr double kSameBranch = 0.1;  // [rad] of turn: both stages found the same pose. Chosen by hand
constexpr double kLeastWeight = 1e-9;
constexpr std::size_t kCorners = 4;

/// Near the line of sight, errors of corners may leave one minimum only, in the middle or on either side of it.
void addMirrored(const CameraModel& camera, const Correspondences& corners, MarkerEstimate& marker) {
  PoseHypothesis other = marker.best();
  other.pose = mirrored(marker.best().pose);
  if (samePose(other.pose, marker.best().pose)) return;
  other.chi_squared = chiSquared(camera, corners, other.pose);
  other.error = reprojectionError(camera, corners, other.pose);
  if (std::exp(0.5 * (marker.best().chi_squared - other.chi_squared)) > kUndecided) marker.hypotheses.push_back(other);
}

}  // namespace

std::optional<MarkerEstimate> cornersEstimate(const CameraModel& camera, const MarkerEstimate& marker,
                                              const PosePrior& prior, const PoseParameters& parameters) {
  MarkerCorners corners = marker.image;
  const double usual = corners.edges_fitted ? parameters.corner_sigma : parameters.corner_sigma_coarse;
  const bool sure =
      corners.edges_fitted && corners.side() > kLargeMarker && marker.model_sigma < parameters.corner_sigma_coarse;
  const double tails = sure ? 1.0 : kLongTails;
  corners.corner_sigma = tails * std::hypot(usual, marker.model_sigma);
  auto result = estimateMarker(camera, corners, marker.size, prior, parameters);
  const auto points = markerCorrespondences(camera, corners, marker.size, parameters);
  if (!result || !points) return std::nullopt;
  if (result->hypotheses.size() == 1) {
    addMirrored(camera, *points, *result);
    weigh(result->hypotheses, points->size(), prior, parameters.tilt_sigma);
    double smallest = result->best().chi_squared;
    for (const auto& h : result->hypotheses) smallest = std::min(smallest, h.chi_squared);
    result->ambiguity = ambiguity(result->hypotheses, inflation(smallest, points->size()));
  }
  for (auto& h : result->hypotheses) {
    h.covariance *=
        inflation(tails * tails * h.chi_squared, kCorners) / (tails * tails * inflation(h.chi_squared, kCorners));
  }
  result->model_sigma = marker.model_sigma;
  result->image.corner_sigma /= tails;
  return result;
}

void openBranches(const MarkerEstimate& by_corners, MarkerEstimate& marker) {
  const auto& open = by_corners.hypotheses;
  if (open.empty() || marker.hypotheses.empty() || by_corners.branch_known) return;
  const PoseHypothesis decided = marker.best();
  const auto nearer = [&decided](const auto& a, const auto& b) {
    return turnBetween(a.pose, decided.pose) < turnBetween(b.pose, decided.pose);
  };
  const auto near = std::min_element(open.begin(), open.end(), nearer);
  const auto far = std::max_element(open.begin(), open.end(), nearer);
  double likelihood = 1.0, weight = 1.0;  // of the other pose, over those of the fit's
  if (open.size() > 1) {
    const double scale = inflation(std::min(near->chi_squared, far->chi_squared), kCorners);
    likelihood = std::min(1.0, std::exp(0.5 * (near->chi_squared - far->chi_squared) / scale));
    weight = std::min(1.0, far->weight / std::max(kLeastWeight, near->weight));
  }
  if (likelihood <= kUndecided || turnBetween(far->pose, decided.pose) < kSameBranch) return;
  if (marker.hypotheses.size() == 1) marker.hypotheses.push_back(*far);
  marker.hypotheses.resize(2);
  marker.hypotheses[0].weight = 1.0 / (1.0 + weight);
  marker.hypotheses[1].weight = weight / (1.0 + weight);
  marker.ambiguity = likelihood;
}

}  // namespace seater_perception
