#pragma once

#include <map>
#include <vector>

#include "pose/dock_pose.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// The patterns of a dictionary, made once per id.
class PatternBook {
 public:
  explicit PatternBook(const std::string& dictionary) : dictionary_(dictionary) {}
  const MarkerPattern& of(int id);

 private:
  std::string dictionary_;
  std::map<int, MarkerPattern> patterns_;
};

/// Poses of a detected marker, fitted to the grey levels. Begins at all its hypotheses which the corners cannot tell
/// apart; what remains is weighed by the photometric residual and the prior. Covariances are the fit's own. Corners
/// become those of the best pose where no edges were fitted.
///
/// True, but with the poses of the corners, when the print is not as the model has it (bent, cells of another width)
/// and its fitted edges contradict the fitted pose.
///
/// `followed`: the marker is an expectedMarker, whose poses, blur and brightness are near. Then false also when
/// residuals look as if the model did not hold: to be done again from its edges.
///
/// False, and the marker unchanged, when no fit converged or the pattern does not explain the image.
bool refinePhotometrically(const cv::Mat& grey, const CameraModel& camera, const MarkerPattern& pattern,
                           PhotometricRefiner& refiner, const PosePrior& prior, const PoseParameters& parameters,
                           MarkerEstimate& marker, bool followed = false);

/// One joint fit of the dock's pose over the markers of each hypothesis that rests on more than one. A hypothesis is
/// left as it is when the fit does not converge, or explains the image worse than the corners' accuracy allows:
/// prints that hang some pixels beside their places.
void refineBundle(const cv::Mat& grey, const CameraModel& camera, PatternBook& patterns, PhotometricRefiner& refiner,
                  const DockLayout& layout, const Eigen::Vector3d& up, const PoseParameters& parameters,
                  const std::vector<MarkerEstimate>& markers, std::vector<DockHypothesis>& dock);

}  // namespace seater_perception
