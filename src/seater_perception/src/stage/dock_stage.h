#pragma once

#include <vector>

#include "seater_perception/dock_layout.h"
#include "stage/marker_stage.h"

namespace seater_perception {

/// How the joint fit of the dock ended.
enum class DockOutcome {
  refined,        ///< hypotheses are those of the joint fit
  too_few,        ///< they rest on fewer than two markers that the model holds for
  contradictory,  ///< they rest on different markers
  displaced       ///< no fit converged, or all leave a marker's corners aside: prints hang beside their places
};

struct RefinedDock {
  DockOutcome outcome = DockOutcome::too_few;
  std::vector<DockHypothesis> dock;  ///< changed only when the outcome is `refined`
};

/// One joint fit of the dock's pose over the grey levels of all markers that its hypotheses rest on and the image model
/// holds for; the others' corners are then added (a step of least squares, all weighed by their covariances). `up`:
/// unit vector pointing up, in the optical frame.
RefinedDock refineDock(const PhotometricContext& context, const DockLayout& layout, const Eigen::Vector3d& up,
                       const std::vector<MarkerEstimate>& markers, const std::vector<DockHypothesis>& dock);

}  // namespace seater_perception
