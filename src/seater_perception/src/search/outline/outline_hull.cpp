#include "search/outline/outline_hull.h"

namespace seater_perception {
namespace {

/// Twice the area of the triangle: whether c lies to one side of a-b, to the other, or on it.
int side(const cv::Point& a, const cv::Point& b, const cv::Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Adds a point to a chain that turns one way (A. M. Andrew, "Another efficient algorithm for convex hulls in two
/// dimensions", 1979). `first`: where the chain begins.
void add(const cv::Point& p, std::size_t first, std::vector<cv::Point>& chain) {
  while (chain.size() >= first + 2 && side(chain[chain.size() - 2], chain.back(), p) <= 0) chain.pop_back();
  if (chain.empty() || chain.back() != p) chain.push_back(p);
}

}  // namespace

std::vector<cv::Point> convexHullOf(int top, const std::vector<RowExtent>& rows) {
  std::vector<cv::Point> hull;
  if (rows.empty()) return hull;
  const int count = static_cast<int>(rows.size());
  // Down the right side, up the left.
  for (int y = 0; y < count; ++y) add({rows[static_cast<std::size_t>(y)].last, top + y}, 0, hull);
  const std::size_t turn = hull.size() - 1;
  for (int y = count - 1; y >= 0; --y) add({rows[static_cast<std::size_t>(y)].first, top + y}, turn, hull);
  if (hull.size() > 1 && hull.back() == hull.front()) hull.pop_back();
  return hull;
}

}  // namespace seater_perception
