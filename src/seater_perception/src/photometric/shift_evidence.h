#pragma once

#include "photometric/photometric_problem.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// What a fit of one print, at its minimum, has left over of shifts of 3 x 3 tiles of it; whatever else is fitted is
/// eliminated. `variance`: of the residuals [grey levels^2]. Tells nothing when the print is seen edge-on.
ShiftEvidence shiftEvidence(const PhotometricProblem& problem, const PhotometricState& state, const Weighing& weighing,
                            double variance);

}  // namespace seater_perception
