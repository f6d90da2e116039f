#include "seater_perception/dock_tracker.h"

#include <algorithm>

#include "image/image_checks.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {
namespace {

constexpr double kSmallCell = 8.0;     // [px] up to here, the code's corners are near enough to begin a fit
constexpr int kShadowsEvery = 4;       // [images] without markers: strong shadows are looked for so often
constexpr double kReachByDock = 0.17;  // [sides] one cell: for markers that were not seen in the last image

double sideOf(const std::array<Eigen::Vector2d, 4>& corners) {
  MarkerCorners marker;
  marker.corners = corners;
  return marker.side();
}

}  // namespace

DockTracker::DockTracker(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                         const CameraMount& mount)
    : detector_(camera, layout, parameters, mount), parameters_(parameters.tracking) {}

void DockTracker::reset() {
  last_ = DetectionResult();
  before_.clear();
  doubtful_.clear();
  since_full_search_ = 0;
  empty_ = 0;
}

std::optional<DockTracker::Corners> DockTracker::project(const Eigen::Isometry3d& T_optical_marker, double size) const {
  const CameraModel& camera = detector_.camera();
  const auto points = markerCorners(size);
  Corners corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = camera.project(T_optical_marker * points[i]);
    if (!pixel) return std::nullopt;
    if (!(pixel->x() > 0.0 && pixel->y() > 0.0 && pixel->x() < camera.width() && pixel->y() < camera.height()))
      return std::nullopt;
    corners[i] = *pixel;
  }
  return corners;
}

std::map<int, DockTracker::Corners> DockTracker::predict(const std::optional<Eigen::Isometry3d>& T_now_last) const {
  const Eigen::Isometry3d motion = T_now_last.value_or(Eigen::Isometry3d::Identity());
  std::map<int, Corners> predicted;
  // The dock tells where its other markers have to be.
  if (!last_.dock.empty()) {
    for (const auto& [id, marker] : detector_.layout().markers) {
      const auto corners = project(motion * last_.dock.front().pose * marker.T_dock_marker(), marker.size);
      if (corners && sideOf(*corners) >= detector_.parameters().detector.min_side) predicted[id] = *corners;
    }
  }
  for (const DetectedMarker& marker : last_.markers) {
    Corners corners = marker.image.corners;
    const auto earlier = before_.find(marker.image.id);
    if (T_now_last) {
      const auto moved = project(motion * marker.best().pose, marker.size);
      if (!moved) continue;
      corners = *moved;
    } else if (earlier != before_.end()) {
      for (std::size_t i = 0; i < 4; ++i) corners[i] += marker.image.corners[i] - earlier->second[i];
    }
    predicted[marker.image.id] = corners;
  }
  for (const int id : doubtful_) predicted.erase(id);
  return predicted;
}

std::vector<MarkerCorners> DockTracker::follow(const cv::Mat& grey, const std::map<int, Corners>& predicted,
                                               std::vector<MarkerCorners> found) const {
  std::vector<ExpectedMarker> expected;
  for (const auto& [id, corners] : predicted) {
    const int wanted = id;
    if (std::any_of(found.begin(), found.end(), [wanted](const MarkerCorners& m) { return m.id == wanted; })) continue;
    ExpectedMarker e;
    e.id = id;
    e.corners = corners;
    const auto is_it = [wanted](const DetectedMarker& m) { return m.image.id == wanted; };
    const auto last = std::find_if(last_.markers.begin(), last_.markers.end(), is_it);
    e.by_outline = last != last_.markers.end();
    // What the dock's pose alone tells is exact, or not worth a longer look in every image.
    const double side = sideOf(corners);
    e.reach = e.by_outline ? std::max(parameters_.margin_min, parameters_.margin * side) : kReachByDock * side;
    if (e.by_outline) {
      const bool fitted = detector_.parameters().refinement == "photometric" && last->image.blur_sd > 0.0;
      e.code_blur = last->image.code_blur;
      e.edges = !fitted || side > kSmallCell * detector_.markerDetector().cells();
    }
    expected.push_back(e);
  }
  for (const MarkerCorners& marker : detector_.markerDetector().follow(grey, expected, parameters_.min_evidence)) {
    found.push_back(marker);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return found;
}

/// As they are expected to stand now; without odometry, their corners alone tell that.
std::map<int, DetectedMarker> DockTracker::lastMarkers(const std::optional<Eigen::Isometry3d>& T_now_last) const {
  std::map<int, DetectedMarker> markers;
  for (DetectedMarker marker : last_.markers) {
    for (PoseHypothesis& h : marker.hypotheses) h.pose = T_now_last.value_or(Eigen::Isometry3d::Identity()) * h.pose;
    markers.emplace(marker.image.id, marker);
  }
  return markers;
}

DetectionResult DockTracker::detect(const cv::Mat& grey, const std::optional<Eigen::Isometry3d>& T_now_last) {
  checkImage(grey, detector_.camera());
  auto predicted = parameters_.enabled ? predict(T_now_last) : std::map<int, Corners>();
  DetectionResult result;
  result.full_search = true;
  if (!predicted.empty() && since_full_search_ + 1 < parameters_.full_search_every) {
    result = detector_.evaluate(grey, follow(grey, predicted, {}), lastMarkers(T_now_last));
    result.full_search = result.markers.empty();
  }
  if (result.full_search) {
    doubtful_.clear();
    const auto found = detector_.markerDetector().detect(grey, &doubtful_, empty_ % kShadowsEvery == 0);
    for (const int id : doubtful_) predicted.erase(id);
    result = detector_.evaluate(grey, follow(grey, predicted, found));
    result.full_search = true;
  }
  since_full_search_ = result.full_search ? 0 : since_full_search_ + 1;
  empty_ = result.markers.empty() ? empty_ + 1 : 0;
  before_.clear();
  for (const DetectedMarker& m : last_.markers) before_[m.image.id] = m.image.corners;
  last_ = result;
  return result;
}

}  // namespace seater_perception
