// Markers in an image without poses, of a family or of whichever family there is.
#pragma once

#include <string>
#include <vector>

#include "search/marker_detector.h"
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

/// Searches an image for one family after the other. One per thread, as MarkerDetector.
class FamilySearch {
 public:
  /// Throws ConfigurationError for a family without markers.
  FamilySearch(const std::vector<MarkerFamily>& families, const DetectorParameters& parameters);

  /// Families that are seen, the one with the most markers first, and of equal ones the one that is seen less often by
  /// chance. A place is one family's only: the first one's. Each is named by the smallest known family whose ids are
  /// enough: DICT_4X4_50 rather than DICT_4X4_1000, which begins with the same codes. Throws ImageError.
  std::vector<FamilyMarkers> detect(const cv::Mat& grey) const;

 private:
  std::vector<MarkerFamily> families_;
  std::vector<MarkerDetector> detectors_;
};

/// Every family that MarkerFamily::names lists, without those that begin another one.
std::vector<MarkerFamily> allFamilies();

}  // namespace seater_perception
