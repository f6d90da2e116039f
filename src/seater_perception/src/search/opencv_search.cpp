#include "search/opencv_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

namespace seater_perception {
namespace {

/// Half window of the refinement [px]: a fixed part of the marker's shortest cell.
int cornerWindow(const MarkerCorners& marker, int cells, const DetectorParameters& parameters) {
  const double cell = shortestSide(marker.corners) / cells;
  const int window = static_cast<int>(std::lround(parameters.corner_window * cell));
  return std::clamp(window, parameters.corner_window_min, parameters.corner_window_max);
}

/// The family as OpenCV has it.
cv::Ptr<cv::aruco::Dictionary> dictionaryOf(const MarkerFamily& family) {
  const auto dictionary = cv::makePtr<cv::aruco::Dictionary>();
  dictionary->markerSize = family.bits();
  dictionary->maxCorrectionBits = family.correctableBits();
  for (int id = 0; id < family.count(); ++id) {
    cv::Mat bits(family.bits(), family.bits(), CV_8UC1);
    int i = 0;
    for (const auto& row : family.code(id)) std::copy(row.begin(), row.end(), bits.ptr<uchar>(i++));
    dictionary->bytesList.push_back(cv::aruco::Dictionary::getByteListFromBits(bits));
  }
  return dictionary;
}

}  // namespace

OpenCvSearch::OpenCvSearch(const MarkerFamily& family, const std::set<int>& ids, const DetectorParameters& parameters)
    : dictionary_(parameters.search == "opencv" ? dictionaryOf(family) : nullptr),
      border_(family.border()),
      ids_(ids),
      parameters_(parameters) {}

std::vector<MarkerCorners> OpenCvSearch::find(const cv::Mat& grey) const {
  const DetectorParameters& p = parameters_;
  const auto settings = cv::aruco::DetectorParameters::create();
  settings->adaptiveThreshWinSizeMin = p.threshold_window_min;
  settings->adaptiveThreshWinSizeMax = p.threshold_window_max;
  settings->adaptiveThreshWinSizeStep = p.threshold_window_step;
  settings->adaptiveThreshConstant = p.threshold_constant;
  settings->minMarkerPerimeterRate = 4.0 * p.min_side / std::max(grey.cols, grey.rows);  // OpenCV wants it relative
  settings->errorCorrectionRate = p.error_correction_rate;
  settings->markerBorderBits = border_;
  settings->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;

  std::vector<std::vector<cv::Point2f>> outlines;
  std::vector<int> found;
  cv::aruco::detectMarkers(grey, dictionary_, outlines, found, settings);

  std::vector<MarkerCorners> markers;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!ids_.empty() && !ids_.count(found[i])) continue;
    MarkerCorners marker;
    marker.id = found[i];
    for (std::size_t k = 0; k < 4; ++k) marker.corners[k] = Eigen::Vector2d(outlines[i][k].x, outlines[i][k].y);
    markers.push_back(marker);
  }
  return markers;
}

void refineSubPixel(const cv::Mat& grey, int cells, const DetectorParameters& parameters, MarkerCorners& marker) {
  const int window = cornerWindow(marker, cells, parameters);
  std::vector<cv::Point2f> points;
  for (const auto& c : marker.corners) points.emplace_back(c.x(), c.y());
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 0.002);
  cv::cornerSubPix(grey, points, cv::Size(window, window), cv::Size(-1, -1), stop);
  for (std::size_t i = 0; i < 4; ++i) marker.corners[i] = Eigen::Vector2d(points[i].x, points[i].y);
}

}  // namespace seater_perception
