// OpenCV's own search for markers, and its corner refinement: `search: opencv`.
#pragma once

#include <opencv2/aruco.hpp>
#include <set>
#include <vector>

#include "search/marker_detector.h"

namespace seater_perception {

/// What detectMarkers finds, of these ids (empty: of all), its corners as found. `grey` is CV_8UC1.
std::vector<MarkerCorners> searchByOpenCv(const cv::Mat& grey, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
                                          const std::set<int>& ids, const DetectorParameters& p);

/// cornerSubPix with a window that follows the size of the marker's `cells`.
void refineSubPixel(const cv::Mat& grey, int cells, const DetectorParameters& parameters, MarkerCorners& marker);

}  // namespace seater_perception
