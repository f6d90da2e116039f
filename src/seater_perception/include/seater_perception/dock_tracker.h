#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "seater_perception/dock_detector.h"

namespace seater_perception {

/// A DockDetector with a memory: after the first find, markers are looked for only near their predicted places. The
/// whole image is searched when nothing is known, when all have been lost, and at every `full_search_every`-th
/// image. Each image has to show the code again: what is not seen is not reported. An id
/// that stands at two places is left out until a search of the whole image shows it at one. Results depend on the
/// images and their order alone, never on time. Not thread-safe; use one per thread.
class DockTracker {
 public:
  /// As DockDetector. Throws ConfigurationError.
  DockTracker(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
              const CameraMount& mount);

  /// As DockDetector::detect. `T_now_last`: pose of the last image's optical frame in this one's (odometry); without
  /// it, markers are expected to move on as between the last two images. Throws ImageError.
  DetectionResult detect(const cv::Mat& grey, const std::optional<Eigen::Isometry3d>& T_now_last = std::nullopt);

  /// Forgets all: the next image is searched as a whole.
  void reset();

  const DockDetector& detector() const { return detector_; }

 private:
  using Corners = std::array<Eigen::Vector2d, 4>;

  std::map<int, Corners> predict(const std::optional<Eigen::Isometry3d>& T_now_last) const;
  std::optional<Corners> project(const Eigen::Isometry3d& T_optical_marker, double size) const;
  std::vector<MarkerCorners> follow(const cv::Mat& grey, const std::map<int, Corners>& predicted,
                                    std::vector<MarkerCorners> found) const;
  std::map<int, DetectedMarker> lastMarkers(const std::optional<Eigen::Isometry3d>& T_now_last) const;

  DockDetector detector_;
  TrackingParameters parameters_;
  DetectionResult last_;
  std::map<int, Corners> before_;  // of the image before the last one
  std::set<int> doubtful_;         // seen at two places by the last search of the whole image
  int since_full_search_ = 0;
  int empty_ = 0;  ///< images without markers since the last one with
};

}  // namespace seater_perception
