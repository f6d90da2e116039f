#include "search/outline/quad_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "search/outline/dark_patches.h"

namespace seater_perception {
namespace {

// Chosen by hand, generously: what is no marker is left for the decoder to refuse. plain_markers_test (turned, tilted,
// small) and perception_range (far and near end) look for markers that are lost, perception_speed for time that is.
constexpr double kFilled = 0.82;            // fraction of the quadrilateral that the outline's hull has to fill
constexpr double kClearlyFilled = 0.96;     // below, something may stick out of the outline
constexpr double kOutlineTolerance = 0.04;  // of the outline's length
constexpr double kSolid = 0.75;             // fraction of the hull that the outline has to enclose
constexpr double kLargestRatio = 6.0;       // of the longest to the shortest side: turned by 80 deg
constexpr double kHullTolerance = 0.012;    // of the outline's length: hull vertices are merged within it
constexpr double kShortestOutline = 2.5;    // [sides]
constexpr double kCleared = 1.05;           // [sides] of a known marker, with the steps of its outline
// Within it, the decoder's fit comes from one to the other (it pulls from a third of a cell); chosen by hand.
constexpr double kSamePart = 0.04, kSame = 1.0;  // [sides], [px]

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Where the lines a-b and c-d meet, and the area of the triangle b, there, c; false when they do not meet outside b-c.
bool prolong(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d,
             Eigen::Vector2d& there, double& area) {
  const Eigen::Vector2d u = b - a, v = c - d;
  const double det = cross(u, v);
  if (std::abs(det) < 1e-9) return false;
  const double s = cross(c - b, v) / det, t = cross(c - b, u) / det;
  if (s < 0.0 || t < 0.0) return false;
  there = b + s * u;
  area = 0.5 * std::abs(cross(there - b, c - b));
  return true;
}

/// Leaves out sides until four are left; false when that is impossible.
bool reduceToFour(std::vector<Eigen::Vector2d>& hull) {
  while (hull.size() > 4) {
    const std::size_t n = hull.size();
    double least = std::numeric_limits<double>::infinity();
    std::size_t side = n;
    Eigen::Vector2d best(0.0, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      Eigen::Vector2d there;
      double area = 0.0;
      if (!prolong(hull[(i + n - 1) % n], hull[i], hull[(i + 1) % n], hull[(i + 2) % n], there, area)) continue;
      if (area < least) least = area, side = i, best = there;
    }
    if (side == n) return false;
    hull[side] = best;
    hull.erase(hull.begin() + static_cast<std::ptrdiff_t>((side + 1) % n));
  }
  return hull.size() == 4;
}

double leastArea(double min_side) {
  return 0.5 * min_side * min_side;
}

double areaOf(const Quad& q) {
  return 0.5 * cross(q[2] - q[0], q[3] - q[1]);
}

/// Sides of sensible lengths; widens it by the half pixel that the outline, which runs through the centres of dark
/// pixels, is inside of the edge.
bool accept(double min_side, Quad& quad) {
  if (areaOf(quad) < 0.0) std::swap(quad[1], quad[3]);
  const Eigen::Vector2d middle = centre(quad);
  const double shortest = shortestSide(quad), longest = longestSide(quad);
  if (shortest + 1.0 < min_side || longest > kLargestRatio * shortest) return false;
  for (auto& c : quad) c += 0.5 * M_SQRT2 * (c - middle).normalized();
  return true;
}

/// The four corners that the outline itself has, when something sticks out of it.
bool fromOutline(const std::vector<cv::Point>& outline, Quad& quad) {
  std::vector<cv::Point> corners;
  cv::approxPolyDP(outline, corners, kOutlineTolerance * static_cast<double>(outline.size()), true);
  if (corners.size() != 4 || !cv::isContourConvex(corners)) return false;
  for (std::size_t i = 0; i < 4; ++i) quad[i] = Eigen::Vector2d(corners[i].x, corners[i].y);
  return true;
}

/// Quadrilaterals that a patch may be meant as: none, one or two.
void toQuads(const cv::Mat& dark, const DarkPatch& patch, double min_side, std::vector<Quad>& quads) {
  if (patch.hull.size() < 4) return;
  std::vector<cv::Point> corners = patch.hull;
  const double hull_area = cv::contourArea(corners);
  if (hull_area < leastArea(min_side)) return;
  const std::vector<cv::Point> outline = outlineOf(dark, patch.first);
  if (static_cast<double>(outline.size()) < kShortestOutline * min_side) return;
  if (cv::contourArea(outline) < kSolid * hull_area) return;
  if (corners.size() > 12) {
    std::vector<cv::Point> fewer;
    cv::approxPolyDP(corners, fewer, kHullTolerance * static_cast<double>(outline.size()), true);
    if (fewer.size() >= 4) corners = fewer;
  }
  std::vector<Eigen::Vector2d> hull;
  for (const auto& p : corners) hull.emplace_back(p.x, p.y);
  Quad quad;
  double filled = 0.0;
  if (reduceToFour(hull)) {
    std::copy(hull.begin(), hull.end(), quad.begin());
    filled = hull_area / std::max(1.0, std::abs(areaOf(quad)));
    if (filled > kFilled && accept(min_side, quad)) quads.push_back(quad);
  }
  if (filled < kClearlyFilled && fromOutline(outline, quad) && accept(min_side, quad)) quads.push_back(quad);
}

/// Nothing is dark there.
void clear(const Quad& quad, cv::Mat& dark) {
  const Eigen::Vector2d middle = centre(quad);
  std::vector<cv::Point> corners;
  for (const auto& c : quad) {
    const Eigen::Vector2d p = middle + kCleared * (c - middle);
    corners.emplace_back(cvRound(p.x()), cvRound(p.y()));
  }
  cv::fillConvexPoly(dark, corners, 0);
}

}  // namespace

std::vector<Quad> findQuads(const cv::Mat& grey, const QuadSearch& search, const std::vector<Quad>& known) {
  std::vector<Quad> quads;
  if (grey.cols < 5 || grey.rows < 5) return quads;
  cv::Mat dark = darkPixels(grey, search);
  for (const Quad& quad : known) clear(quad, dark);
  // The outline runs through dark pixels: in the image's outermost row, what lies beyond is not seen.
  for (const DarkPatch& patch : darkPatches(dark, leastArea(search.min_side)))
    toQuads(dark, patch, search.min_side, quads);
  return quads;
}

bool sameOutline(const Quad& a, const Quad& b) {
  const double tolerance = std::max(kSame, kSamePart * meanSide(a)), square = tolerance * tolerance;
  for (const auto& corner : a) {
    const auto near = [&](const Eigen::Vector2d& other) { return (corner - other).squaredNorm() < square; };
    if (std::none_of(b.begin(), b.end(), near)) return false;
  }
  return true;
}

}  // namespace seater_perception
