#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace seater_perception {

/// Dark pixels that hang together, by their sides or corners.
struct DarkPatch {
  cv::Point first;              ///< the leftmost pixel of its uppermost row
  std::vector<cv::Point> hull;  ///< convex hull of its pixels' centres, corners only, once round
};

/// Patches of a CV_8UC1 image of 255 (dark) and 0 that do not reach its outermost rows and columns, and whose box
/// (between pixels' centres) is at least `least_area` [px^2]. Row by row as runs of pixels, by union and find (K. Wu,
/// E. Otoo, K. Suzuki, "Optimizing two-pass connected-component labeling algorithms", 2009): most patches are noise,
/// and following the outline of each would take most of the time.
std::vector<DarkPatch> darkPatches(const cv::Mat& dark, double least_area);

/// The outer outline of the patch that has its first pixel there, pixel by pixel, as cv::findContours gives it
/// (S. Suzuki and K. Abe, "Topological structural analysis of digitized binary images by border following", 1985). The
/// patch may not reach the image's outermost rows and columns.
std::vector<cv::Point> outlineOf(const cv::Mat& dark, const cv::Point& first);

}  // namespace seater_perception
