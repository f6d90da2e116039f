// Poses of detected markers, refined by grey levels where the image model holds.
#pragma once

#include "pose/marker_pose.h"
#include "stage/pattern_book.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What all refinements in one image share.
struct PhotometricContext {
  const cv::Mat& grey;
  const CameraModel& camera;
  const PoseParameters& pose;
  PhotometricRefiner& refiner;
  PatternBook& patterns;
  double exponent = 1.0;  ///< `grey` is light, grey levels to the power of it (image/exposure.h)
};

/// How the refinement of a marker ended.
enum class MarkerOutcome {
  refined,       ///< poses are those of the grey levels, corners those of the best pose
  corners_kept,  ///< no fit converged, or a clean outline contradicts the cells: poses stay those of the corners
  doubtful       ///< of a tracked marker: no fit, or not as the model has it; to be done again from its edges
};

struct RefinedMarker {
  MarkerOutcome outcome = MarkerOutcome::corners_kept;
  MarkerEstimate marker;   ///< poses are changed only when the outcome is `refined`, model_sigma is set always
  bool deviates = false;   ///< what the fit has left over is more than noise
  ShiftEvidence shifts;    ///< what it has left over of shifts of parts of the print
  double explained = 0.0;  ///< as of PhotometricResult; 0: no fit converged
  /// [px] along each axis, rms: from the outline's own corners to those of the whole print's pose, where `deviates` and
  /// the outline can be relied on.
  double outline_apart = 0.0;
};

/// Poses of a detected marker. Fits begin at all its hypotheses which the corners cannot tell apart. Where the image is
/// not as the model has it, the whole print is fitted, all residuals counted, and `model_holds` is false. Covariances
/// are the fit's own; weights are not set. `tracked`: the marker is an expectedMarker, whose poses, point spread
/// function and brightness are near.
RefinedMarker refineMarker(const PhotometricContext& context, const MarkerEstimate& marker, bool tracked);

/// A refined marker's covariances with those of the image's shifts (standard deviation `shift_sigma` [px]), the poses
/// weighed by photometric residual and prior, and the corners of the best one. No pose is left where none says
/// anything.
void settleMarker(const PhotometricContext& context, const PosePrior& prior, double shift_sigma,
                  MarkerEstimate& marker);

}  // namespace seater_perception
