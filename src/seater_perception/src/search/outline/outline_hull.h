#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace seater_perception {

/// Convex hull of an outline's pixels, corners only, once round. As cv::convexHull, but in the time of one look at each
/// pixel: pixels come from few rows, whose first and last ones are enough, and which are sorted by counting. Empty for
/// an empty outline.
std::vector<cv::Point> convexHullOf(const std::vector<cv::Point>& outline);

}  // namespace seater_perception
