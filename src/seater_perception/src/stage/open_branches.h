// Which of a marker's two poses stays possible, where the camera is not as the image model has it.
#pragma once

#include <optional>

#include "pose/marker_pose.h"

namespace seater_perception {

/// Poses of the corners, which are as uncertain as what the grey levels deviate from the model says (`model_sigma` of
/// `marker`). Errors of corners have long tails there: the branch of a small marker, or one without fitted edges, is
/// decided as if they were twice as uncertain. Where they leave one pose whose mirror
/// image they can hardly tell from it, that one goes out too. Nothing when the corners give no pose.
std::optional<MarkerEstimate> cornersEstimate(const CameraModel& camera, const MarkerEstimate& marker,
                                              const PosePrior& prior, const PoseParameters& parameters);

/// Adds to `marker`, whose photometric fit has decided, the other pose if its corners do not rule that out
/// (`by_corners`, of cornersEstimate): residuals that are alike from pixel to pixel, as smooth shifts of some tenths of
/// a pixel leave them, may favour the wrong one by any amount. The fit's choice stays the most probable one.
void openBranches(const MarkerEstimate& by_corners, MarkerEstimate& marker);

}  // namespace seater_perception
