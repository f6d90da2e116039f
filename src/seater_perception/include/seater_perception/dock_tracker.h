#pragma once

#include <memory>
#include <optional>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// A DockDetector with a memory: after the first find, markers are looked for only near their predicted places. The
/// whole image is searched when nothing is known, when all have been lost, and at every `full_search_every`-th image.
/// Each image has to show the code again: what is not seen is not reported. An id that stands at two places is left out
/// until a search of the whole image shows it at one. Results depend on the images and their order alone, never on
/// time. One per thread.
class DockTracker {
 public:
  /// As DockDetector. Throws ConfigurationError.
  DockTracker(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
              const CameraMount& mount);
  ~DockTracker();
  DockTracker(DockTracker&&) noexcept;

  /// As DockDetector::detect. `T_now_last`: pose of the last image's optical frame in this one's (odometry); without
  /// it, markers are expected to move on as between the last two images. Throws ImageError.
  DetectionResult detect(const cv::Mat& grey, const std::optional<Eigen::Isometry3d>& T_now_last = std::nullopt);

  /// Forgets all: the next image is searched as a whole.
  void reset();

  const CameraModel& camera() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
