// Poses of detected markers and of the dock, refined by grey levels.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "pose/dock_pose.h"
#include "seater_perception/marker_family.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// The patterns of a family, made once per id.
class PatternBook {
 public:
  explicit PatternBook(const MarkerFamily& family) : family_(family) {}
  const MarkerPattern& of(int id);

 private:
  MarkerFamily family_;
  std::map<int, MarkerPattern> patterns_;
};

/// What all refinements in one image share.
struct PhotometricContext {
  const cv::Mat& grey;
  const CameraModel& camera;
  const PoseParameters& pose;
  PhotometricRefiner& refiner;
  PatternBook& patterns;
};

/// How the refinement of a marker ended.
enum class MarkerOutcome {
  refined,       ///< poses are those of the grey levels, corners those of the best pose
  corners_kept,  ///< the print is proved, but not as the model has it (bent, cells of another width), and its fitted
                 ///< edges contradict the fitted pose: poses stay those of the corners
  doubtful,      ///< of a tracked marker: no fit converged, or residuals look as if the model did not hold; to be done
                 ///< again from its edges
  refused        ///< no fit converged, or the pattern does not explain the image
};

struct RefinedMarker {
  MarkerOutcome outcome = MarkerOutcome::refused;
  MarkerEstimate marker;  ///< changed only when the outcome is `refined`
};

/// Poses of a detected marker. Fits begin at all its hypotheses which the corners cannot tell apart; what remains is
/// weighed by the photometric residual and the prior. Covariances are the fit's own. `tracked`: the marker is an
/// expectedMarker, whose poses, point spread function and brightness are near.
RefinedMarker refineMarker(const PhotometricContext& context, const PosePrior& prior, const MarkerEstimate& marker,
                           bool tracked);

/// How the joint fit of the dock ended.
enum class DockOutcome {
  refined,        ///< hypotheses are those of the joint fit
  too_few,        ///< they rest on one marker only
  contradictory,  ///< they rest on different markers
  displaced       ///< no fit converged, or all leave a marker's corners aside: prints hang beside their places
};

struct RefinedDock {
  DockOutcome outcome = DockOutcome::too_few;
  std::vector<DockHypothesis> dock;  ///< changed only when the outcome is `refined`
};

/// One joint fit of the dock's pose over all markers that its hypotheses rest on. `up`: unit vector pointing up, in the
/// optical frame.
RefinedDock refineDock(const PhotometricContext& context, const DockLayout& layout, const Eigen::Vector3d& up,
                       const std::vector<MarkerEstimate>& markers, const std::vector<DockHypothesis>& dock);

}  // namespace seater_perception
