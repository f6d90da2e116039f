#include "search/outline/outline_hull.h"

#include <algorithm>
#include <limits>

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

std::vector<cv::Point> convexHullOf(const std::vector<cv::Point>& outline) {
  std::vector<cv::Point> hull;
  if (outline.empty()) return hull;
  const auto by_row = [](const cv::Point& a, const cv::Point& b) { return a.y < b.y; };
  const auto [top, bottom] = std::minmax_element(outline.begin(), outline.end(), by_row);
  struct Row {
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
  };
  const int y0 = top->y, count = bottom->y - y0 + 1;
  std::vector<Row> rows(static_cast<std::size_t>(count));
  for (const cv::Point& p : outline) {
    Row& row = rows[static_cast<std::size_t>(p.y - y0)];
    row.first = std::min(row.first, p.x);
    row.last = std::max(row.last, p.x);
  }
  // An outline is connected: no row is empty. Down its right side, up its left.
  for (int y = 0; y < count; ++y) add({rows[static_cast<std::size_t>(y)].last, y0 + y}, 0, hull);
  const std::size_t turn = hull.size() - 1;
  for (int y = count - 1; y >= 0; --y) add({rows[static_cast<std::size_t>(y)].first, y0 + y}, turn, hull);
  if (hull.size() > 1 && hull.back() == hull.front()) hull.pop_back();
  return hull;
}

}  // namespace seater_perception
