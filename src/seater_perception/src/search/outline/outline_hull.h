#pragma once

#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace seater_perception {

/// Where the pixels of a row begin and end.
struct RowExtent {
  int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();

  void add(int from, int to) { first = std::min(first, from), last = std::max(last, to); }
};

/// Convex hull of the pixels of rows one below the other, the first one `top`; none may be empty. Corners only, once
/// round, as cv::convexHull, but in the time of one look at each row.
std::vector<cv::Point> convexHullOf(int top, const std::vector<RowExtent>& rows);

}  // namespace seater_perception
