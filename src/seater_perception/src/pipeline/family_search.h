// Markers in an image without poses, of a family or of whichever family there is.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "search/marker_detector.h"
#include "search/outline_judge.h"
#include "seater_perception/detection.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What an image shows of one family.
struct FamilyMarkers {
  MarkerFamily family;
  std::vector<PlainMarker> markers;  ///< ascending id; one that stands at several places is there several times
};

/// What looks like a marker and is refused.
struct RefusedCandidate {
  std::array<Eigen::Vector2d, 4> corners;  ///< [px]
  std::optional<int> id;                   ///< that it would be
  std::string why;                         ///< for a person
};

/// Searches an image for one family after the other. One per thread, as MarkerDetector.
class FamilySearch {
 public:
  /// At least one family. Throws ConfigurationError for one without markers.
  FamilySearch(const std::vector<MarkerFamily>& families, const DetectorParameters& parameters);

  /// Families that are seen, the one with the most markers first, and of equal ones the one that is seen less often by
  /// chance. A place is one family's only: the first one's. Each is named by the smallest known family whose ids are
  /// enough: DICT_4X4_50 rather than DICT_4X4_1000, which begins with the same codes. Throws ImageError.
  std::vector<FamilyMarkers> detect(const cv::Mat& grey) const;

  /// Of the first family: candidates apart from the markers that were found. Throws ImageError.
  std::vector<RefusedCandidate> refusals(const cv::Mat& grey, const std::vector<PlainMarker>& found) const;

 private:
  DetectorParameters parameters_;
  std::vector<MarkerFamily> families_;
  std::vector<MarkerDetector> detectors_;
  OutlineJudge judge_;  // of the first family
};

/// Every family that MarkerFamily::names lists, without those that begin another one. `left_out`: for each file in the
/// folders of families that is none, which one and why.
std::vector<MarkerFamily> allFamilies(std::vector<std::string>& left_out);

}  // namespace seater_perception
