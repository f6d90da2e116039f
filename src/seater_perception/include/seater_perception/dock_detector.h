#pragma once

#include <vector>

#include "seater_perception/camera_model.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/dock_pose.h"
#include "seater_perception/marker_detector.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What one picture shows.
struct DetectionResult {
  std::vector<DetectedMarker> markers;  ///< ascending id
  std::vector<DockHypothesis> dock;     ///< most probable first; empty when the dock is not seen
  int refused = 0;                      ///< markers of the layout that were found, but whose pose was not believable
};

/// Picture in, markers and dock out: all that a user of this library needs. Not thread-safe; use one per thread.
///
///     DockDetector detector(CameraModel::raw(loadCalibration("camera.yaml")),
///                           loadDockLayout(YAML::LoadFile("dock.yaml"), "dock"), PerceptionParameters(),
///                           CameraMount());
///     DetectionResult result = detector.detect(grey);
class DockDetector {
 public:
  /// Throws ConfigurationError for an unknown dictionary.
  DockDetector(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
               const CameraMount& mount);

  /// The picture has to be CV_8UC1 and of the camera's size; every number of the result is finite. Throws PictureError.
  DetectionResult detect(const cv::Mat& grey) const;

  void setCamera(const CameraModel& camera) { camera_ = camera; }
  const CameraModel& camera() const { return camera_; }
  const DockLayout& layout() const { return layout_; }

 private:
  CameraModel camera_;
  DockLayout layout_;
  PerceptionParameters parameters_;
  Eigen::Vector3d up_;  // in the optical frame
  MarkerDetector detector_;
};

}  // namespace seater_perception
