#pragma once

#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/family_search.h"
#include "seater_perception/dock_detector.h"
#include "seater_perception/report.h"
#include "tools/options.h"

namespace seater_perception {

/// Detectors as images ask for them: one for each family, and, without a calibration, for each size of images.
class Detectors {
 public:
  /// `options` have to outlive it. Throws ConfigurationError: a file or an option is wrong.
  explicit Detectors(const Options& options);

  const MarkerFamily& family() const { return family_; }  ///< that is looked for; with `any`, there is none
  /// Finds the family (`any`) or the markers alone; nothing when the family is known and poses are wanted.
  const FamilySearch* search() const { return search_.get(); }
  /// Files in the folders of families that are none, and why: `any` goes on without them.
  const std::vector<std::string>& leftOut() const { return left_out_; }
  /// What was not found, and why, where one family is looked for; of `any`, nothing is said.
  std::vector<RefusedCandidate> refusals(const cv::Mat& grey, const DetectionResult& result);
  std::vector<RefusedCandidate> refusals(const cv::Mat& grey, const std::vector<PlainMarker>& found);
  /// What the dock in it tells of the focal length.
  std::optional<FocalCheck> focalLength(const DockDetector& detector, const DetectionResult& result) const;
  /// Of images of this size. Throws ConfigurationError.
  DockDetector& of(const MarkerFamily& family, const cv::Size& image);

 private:
  CameraModel cameraFor(const cv::Size& image) const;

  const Options& options_;
  PerceptionParameters parameters_;
  std::optional<Calibration> calibration_;
  MarkerFamily family_;
  std::vector<std::string> left_out_;
  std::unique_ptr<FamilySearch> search_;
  std::unique_ptr<FamilySearch> explainer_;  // of the one family
  std::optional<DockLayout> layout_;         // that poses are wanted of
  std::map<std::pair<std::string, std::pair<int, int>>, DockDetector> detectors_;
};

}  // namespace seater_perception
