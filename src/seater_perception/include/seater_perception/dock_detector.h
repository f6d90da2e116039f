#pragma once

#include <memory>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// Image in, markers and dock out. Each image is searched as a whole; DockTracker is faster on a sequence.
///
///     DockDetector detector(CameraModel::raw(loadCalibration("camera.yaml")),
///                           loadDockLayout(YAML::LoadFile("dock.yaml"), "dock"), PerceptionParameters(),
///                           CameraMount());
///     DetectionResult result = detector.detect(grey);
///
/// One per thread: `detect` writes into memory that the next call uses again. Results do not depend on earlier calls.
class DockDetector {
 public:
  /// Throws ConfigurationError for a layout whose family has no markers.
  DockDetector(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
               const CameraMount& mount);
  ~DockDetector();
  DockDetector(DockDetector&&) noexcept;

  /// The image has to be CV_8UC1 and of the camera's size; every number of the result is finite. Throws ImageError.
  DetectionResult detect(const cv::Mat& grey);

  const CameraModel& camera() const;
  const DockLayout& layout() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
