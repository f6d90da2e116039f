// From photometric fits to hypotheses of a pose.
#pragma once

#include <vector>

#include "pose/hypotheses.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// Part of the image's variance that the pattern has to explain: a small marker has to be proved by it, a large one
/// has been read bit by bit and may be partly covered. Chosen by hand between what true markers and what other dark
/// squares show: `perception_accuracy` counts missed markers and `perception_range` false ones; detection_test,
/// plain_markers_test and tracker_cases_test notice too.
constexpr double kExplainedSmall = 0.9, kExplainedLarge = 0.85;

/// Distinct results that explain more than `smallest`, as hypotheses; chi_squared counts from the best one.
std::vector<PoseHypothesis> distinct(const std::vector<PhotometricBranch>& branches, double smallest);

/// Adds what camera and print may deviate from the model: as if corners were uncertain by `sigma` [px].
void addModelError(const CameraModel& camera, Correspondences corners, double sigma,
                   std::vector<PoseHypothesis>& hypotheses);

/// Weights by chi_squared and prior; most probable first. `hypotheses` must not be empty.
void weighByPrior(std::vector<PoseHypothesis>& hypotheses, const PosePrior& prior, double tilt_sigma);

}  // namespace seater_perception
