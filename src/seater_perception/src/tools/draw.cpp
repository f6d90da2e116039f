#include "seater_perception/draw.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/format.h"
#include "seater_perception/report.h"
#include "tools/strokes.h"

namespace seater_perception {
namespace {

const cv::Scalar kGreen(40, 220, 40), kBlue(255, 120, 40), kText(255, 255, 255);

/// True when a pixel is near enough to the image to be drawn without running over cv::line's integers.
bool drawable(const cv::Mat& image, const Eigen::Vector2d& p) {
  return p.allFinite() && std::abs(p.x()) < 10.0 * image.cols && std::abs(p.y()) < 10.0 * image.rows;
}

void line(cv::Mat& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& colour, int width) {
  if (!drawable(image, a) || !drawable(image, b)) return;
  cv::line(image, fine(a), fine(b), colour, width, cv::LINE_AA, kShift);
}

void text(cv::Mat& image, const std::string& words, cv::Point at, double scale) {
  const int thick = strokeWidth(2.0 * scale);
  cv::putText(image, words, at, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(0, 0, 0), thick + 3, cv::LINE_AA);
  cv::putText(image, words, at, cv::FONT_HERSHEY_SIMPLEX, scale, kText, thick, cv::LINE_AA);
}

/// Axes of a frame, x red, y green, z blue; an axis whose end is behind the camera is left out.
void axes(cv::Mat& image, const CameraModel& camera, const Eigen::Isometry3d& pose, double length, int width) {
  const auto origin = camera.project(pose.translation());
  if (!origin) return;
  const cv::Scalar colours[] = {kRed, kGreen, kBlue};
  for (int i = 0; i < 3; ++i) {
    const auto end = camera.project(pose * Eigen::Vector3d(length * Eigen::Vector3d::Unit(i)));
    if (end) line(image, *origin, *end, colours[i], width);
  }
}

/// The dock frame lies on the floor, most often below the image: its axes are drawn at the markers' middle, where
/// they show.
void dock(cv::Mat& image, const CameraModel& camera, const DockLayout& layout, const DockHypothesis& h, double scale) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& [id, place] : layout.markers) middle += place.position / static_cast<double>(layout.markers.size());
  const Eigen::Isometry3d raised = h.pose * Eigen::Translation3d(middle);
  axes(image, camera, raised, 0.25, strokeWidth(3.0 * scale));
  const auto end = camera.project(raised * Eigen::Vector3d(0.0, 0.0, 0.27));
  if (end && drawable(image, *end)) text(image, "dock", {cvRound(end->x()), cvRound(end->y())}, 0.7 * scale);
}

std::string words(const char* pattern, const Placement& p) {
  return format(pattern, p.distance, p.lateral, kDegrees * p.angle);
}

void marker(cv::Mat& image, const CameraModel& camera, const DetectedMarker& m, double scale) {
  const auto& c = m.corners;
  const int width = strokeWidth(2.0 * scale);
  for (std::size_t i = 0; i < 4; ++i) line(image, c[i], c[(i + 1) % 4], kOutline, width);
  cv::circle(image, fine(c[0]), cvRound(4.0 * scale) << kShift, kRed, width, cv::LINE_AA, kShift);
  axes(image, camera, m.best().pose, 0.5 * m.size, width);
  const Eigen::Vector2d lowest((c[0].x() + c[1].x() + c[2].x() + c[3].x()) / 4.0,
                               std::max({c[0].y(), c[1].y(), c[2].y(), c[3].y()}));
  const cv::Point at(cvRound(lowest.x() - 20.0 * scale), cvRound(lowest.y() + 26.0 * scale));
  text(image, "id " + std::to_string(m.id), at, 0.7 * scale);
}

}  // namespace

cv::Mat annotate(const cv::Mat& grey, const CameraModel& camera, const DockLayout& layout,
                 const DetectionResult& result, const std::vector<std::string>& lines) {
  cv::Mat image;
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  const double scale = strokeScale(image);
  std::vector<std::string> all;
  for (const DetectedMarker& m : result.markers) {
    marker(image, camera, m, scale);
    all.push_back("marker " + std::to_string(m.id) + ": " +
                  words("%.3f m away, %+.3f m right, turned %+.1f deg, ", markerPlacement(m.best().pose)) +
                  std::to_string(std::lround(m.side)) + " px, by " + nameOf(m.stage));
  }
  if (!result.dock.empty()) {
    dock(image, camera, layout, result.dock.front(), scale);
    all.push_back(
        words("dock: %.3f m away, %+.3f m right, heading %+.1f deg", dockPlacement(result.dock.front().pose)));
  } else {
    all.emplace_back(result.markers.empty() ? "no marker found" : "no dock");
  }
  all.insert(all.end(), lines.begin(), lines.end());
  double y = 30.0 * scale;
  for (const std::string& entry : all) {
    text(image, entry, {cvRound(12.0 * scale), cvRound(y)}, 0.7 * scale);
    y += 30.0 * scale;
  }
  return image;
}

}  // namespace seater_perception
