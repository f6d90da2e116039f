#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "photometric/photometric_stage.h"
#include "pose/dock_pose.h"
#include "search/marker_detector.h"
#include "seater_perception/camera_model.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What one image shows.
struct DetectionResult {
  std::vector<DetectedMarker> markers;  ///< ascending id
  std::vector<DockHypothesis> dock;     ///< most probable first; empty when the dock is not seen
  int refused = 0;                      ///< markers of the layout that were found, but whose pose was not believable
  bool full_search = true;              ///< false: only the predicted places were searched
};

/// Image in, markers and dock out: all that a user of this library needs. Not thread-safe; use one per thread.
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

  /// The image has to be CV_8UC1 and of the camera's size; every number of the result is finite. Throws ImageError.
  DetectionResult detect(const cv::Mat& grey) const;

  /// Poses of markers that have been found in this image, and of the dock. `last`: markers of the image before, by
  /// id, where they are expected in this one (their poses, that is): fits begin there. Throws ImageError.
  DetectionResult evaluate(const cv::Mat& grey, const std::vector<MarkerCorners>& found,
                           const std::map<int, DetectedMarker>& last = {}) const;

  const MarkerDetector& markerDetector() const { return detector_; }
  const PerceptionParameters& parameters() const { return parameters_; }
  void setCamera(const CameraModel& camera) { camera_ = camera; }
  const CameraModel& camera() const { return camera_; }
  const DockLayout& layout() const { return layout_; }

 private:
  PosePrior priorOf(int id) const;
  std::optional<DetectedMarker> expected(const MarkerCorners& found, const std::map<int, DetectedMarker>& last) const;
  void keepDecided(const std::vector<DockHypothesis>& dock, DetectedMarker& marker) const;
  void refineMarkers(const cv::Mat& grey, const std::set<int>& followed, DetectionResult& result) const;
  bool startAgain(const cv::Mat& grey, DetectedMarker& marker) const;

  CameraModel camera_;
  DockLayout layout_;
  PerceptionParameters parameters_;
  Eigen::Vector3d up_;  // in the optical frame
  MarkerDetector detector_;
  PhotometricRefiner refiner_;
  mutable PatternBook patterns_;  // filled as ids are seen
};

}  // namespace seater_perception
