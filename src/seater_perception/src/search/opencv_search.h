// OpenCV's own search for markers, and its corner refinement: `search: opencv`.
#pragma once

#include <opencv2/aruco.hpp>
#include <set>
#include <vector>

#include "search/marker_detector.h"

namespace seater_perception {

/// OpenCV's detectMarkers.
class OpenCvSearch {
 public:
  /// `ids`: markers looked for; empty: all of the family.
  OpenCvSearch(const MarkerFamily& family, const std::set<int>& ids, const DetectorParameters& parameters);

  /// Markers in an image of CV_8UC1, their corners as found.
  std::vector<MarkerCorners> find(const cv::Mat& grey) const;

 private:
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  int border_;  // [cells]
  std::set<int> ids_;
  DetectorParameters parameters_;
};

/// cornerSubPix with a window that follows the size of the marker's `cells`.
void refineSubPixel(const cv::Mat& grey, int cells, const DetectorParameters& parameters, MarkerCorners& marker);

}  // namespace seater_perception
