#include "seater_perception/marker_detector.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "seater_perception/dock_layout.h"
#include "seater_perception/edge_fit.h"
#include "seater_perception/image_checks.h"

namespace seater_perception {
namespace {

/// Half window of the refinement [px]: a fixed part of the marker's shortest cell.
int cornerWindow(const MarkerCorners& marker, int cells, const DetectorParameters& parameters) {
  const double cell = marker.minSide() / cells;
  const int window = static_cast<int>(std::lround(parameters.corner_window * cell));
  return std::clamp(window, parameters.corner_window_min, parameters.corner_window_max);
}

void refineCorners(const cv::Mat& grey, int window, MarkerCorners& marker) {
  std::vector<cv::Point2f> points;
  for (const auto& c : marker.corners) points.emplace_back(c.x(), c.y());
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 0.002);
  cv::cornerSubPix(grey, points, cv::Size(window, window), cv::Size(-1, -1), stop);
  for (std::size_t i = 0; i < 4; ++i) marker.corners[i] = Eigen::Vector2d(points[i].x, points[i].y);
}

/// One marker per id. Two outlines of the same print (its inner and outer contour) overlap: the larger one is the
/// marker's.
std::vector<MarkerCorners> uniqueMarkers(const std::vector<MarkerCorners>& found) {
  std::map<int, MarkerCorners> best;
  std::map<int, bool> doubtful;
  for (const MarkerCorners& marker : found) {
    const auto [place, is_new] = best.emplace(marker.id, marker);
    if (is_new) continue;
    MarkerCorners& other = place->second;
    const double larger = std::max(marker.side(), other.side());
    if ((marker.centre() - other.centre()).norm() > 0.5 * larger) doubtful[marker.id] = true;
    if (marker.side() > other.side()) other = marker;
  }
  std::vector<MarkerCorners> unique;
  for (const auto& [id, marker] : best) {
    if (!doubtful.count(id)) unique.push_back(marker);
  }
  return unique;
}

}  // namespace

double MarkerCorners::side() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += (corners[(i + 1) % 4] - corners[i]).norm();
  return 0.25 * sum;
}

double MarkerCorners::minSide() const {
  double shortest = (corners[1] - corners[0]).norm();
  for (std::size_t i = 1; i < 4; ++i) shortest = std::min(shortest, (corners[(i + 1) % 4] - corners[i]).norm());
  return shortest;
}

Eigen::Vector2d MarkerCorners::centre() const {
  return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
}

struct MarkerDetector::Implementation {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  DetectorParameters parameters;
};

MarkerDetector::MarkerDetector(const std::string& dictionary, const DetectorParameters& parameters)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->dictionary = cv::aruco::getPredefinedDictionary(dictionaryNumber(dictionary, "dictionary"));
  implementation_->parameters = parameters;
}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;

std::vector<MarkerCorners> MarkerDetector::detect(const cv::Mat& grey) const {
  checkPicture(grey);
  const DetectorParameters& p = implementation_->parameters;
  const auto settings = cv::aruco::DetectorParameters::create();
  settings->adaptiveThreshWinSizeMin = p.threshold_window_min;
  settings->adaptiveThreshWinSizeMax = p.threshold_window_max;
  settings->adaptiveThreshWinSizeStep = p.threshold_window_step;
  settings->adaptiveThreshConstant = p.threshold_constant;
  settings->minMarkerPerimeterRate = 4.0 * p.min_side / std::max(grey.cols, grey.rows);  // OpenCV wants it relative
  settings->errorCorrectionRate = p.error_correction_rate;
  settings->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;

  std::vector<std::vector<cv::Point2f>> outlines;
  std::vector<int> ids;
  cv::aruco::detectMarkers(grey, implementation_->dictionary, outlines, ids, settings);

  std::vector<MarkerCorners> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MarkerCorners marker;
    marker.id = ids[i];
    for (std::size_t k = 0; k < 4; ++k) marker.corners[k] = Eigen::Vector2d(outlines[i][k].x, outlines[i][k].y);
    found.push_back(marker);
  }
  std::vector<MarkerCorners> unique = uniqueMarkers(found);
  const int cells = implementation_->dictionary->markerSize + 2;
  for (MarkerCorners& marker : unique) {
    refineCorners(grey, cornerWindow(marker, cells, p), marker);
    if (!p.edge_fit) continue;
    const double band = std::clamp(p.edge_band * marker.minSide() / cells, p.edge_band_min, p.edge_band_max);
    if (const auto corners = fitEdges(grey, marker.corners, band)) {
      marker.corners = *corners;
      marker.edges_fitted = true;
    }
  }
  return unique;
}

}  // namespace seater_perception
