#include "seater_perception/dock_tracker.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "image/image_checks.h"
#include "pipeline/detection_pipeline.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {
namespace {

// [px] Up to this cell, the code's corners (exact to 0.03 cells: 0.24 px) are near enough to begin a fit, which needs a
// quarter of a pixel.
constexpr double kSmallCell = 8.0;
// [images] without markers: strong shadows are looked for so often, since that doubles the search's time.
constexpr int kShadowsEvery = 4;
constexpr double kReachByDock = 0.17;  // [sides] one cell of six: for markers that were not seen in the last image

}  // namespace

class DockTracker::Implementation {
 public:
  Implementation(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                 const CameraMount& mount)
      : pipeline_(camera, layout, parameters, mount), parameters_(parameters.tracking) {}

  DetectionResult detect(const cv::Mat& grey, const std::optional<Eigen::Isometry3d>& T_now_last);
  const CameraModel& camera() const { return pipeline_.camera(); }
  void reset();

 private:
  std::map<int, Quad> predict(const std::optional<Eigen::Isometry3d>& T_now_last) const;
  std::optional<Quad> project(const Eigen::Isometry3d& T_optical_marker, double size) const;
  std::vector<ExpectedMarker> expected(const std::map<int, Quad>& predicted) const;
  std::map<int, MarkerEstimate> lastMarkers(const std::optional<Eigen::Isometry3d>& T_now_last) const;

  DetectionPipeline pipeline_;
  TrackingParameters parameters_;
  ImageEstimate last_;
  std::map<int, Quad> before_;  // of the image before the last one
  std::set<int> doubtful_;      // seen at two places by the last search of the whole image
  int since_full_search_ = 0;
  int empty_ = 0;  // images without markers since the last one with
};

void DockTracker::Implementation::reset() {
  last_ = ImageEstimate();
  before_.clear();
  doubtful_.clear();
  since_full_search_ = 0;
  empty_ = 0;
}

std::optional<Quad> DockTracker::Implementation::project(const Eigen::Isometry3d& T_optical_marker, double size) const {
  const CameraModel& camera = pipeline_.camera();
  const auto points = markerCorners(size);
  Quad corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = camera.project(T_optical_marker * points[i]);
    if (!pixel) return std::nullopt;
    if (!(pixel->x() > 0.0 && pixel->y() > 0.0 && pixel->x() < camera.width() && pixel->y() < camera.height()))
      return std::nullopt;
    corners[i] = *pixel;
  }
  return corners;
}

std::map<int, Quad> DockTracker::Implementation::predict(const std::optional<Eigen::Isometry3d>& T_now_last) const {
  const Eigen::Isometry3d motion = T_now_last.value_or(Eigen::Isometry3d::Identity());
  std::map<int, Quad> predicted;
  // The dock tells where its other markers have to be.
  if (!last_.dock.empty()) {
    for (const auto& [id, marker] : pipeline_.layout().markers) {
      const auto corners = project(motion * last_.dock.front().pose * marker.T_dock_marker(), marker.size);
      if (corners && meanSide(*corners) >= pipeline_.parameters().detector.min_side) predicted[id] = *corners;
    }
  }
  for (const MarkerEstimate& marker : last_.markers) {
    Quad corners = marker.image.corners;
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

/// How each of these markers is to be looked for.
std::vector<ExpectedMarker> DockTracker::Implementation::expected(const std::map<int, Quad>& predicted) const {
  std::vector<ExpectedMarker> expected;
  for (const auto& [id, corners] : predicted) {
    const int wanted = id;
    ExpectedMarker e;
    e.id = id;
    e.corners = corners;
    e.min_evidence = parameters_.min_evidence;
    const auto is_it = [wanted](const MarkerEstimate& m) { return m.image.id == wanted; };
    const auto last = std::find_if(last_.markers.begin(), last_.markers.end(), is_it);
    e.by_outline = last != last_.markers.end();
    // What the dock's pose alone tells is exact, or does not justify a longer look in every image.
    const double side = meanSide(corners);
    e.reach = e.by_outline ? std::max(parameters_.margin_min, parameters_.margin * side) : kReachByDock * side;
    if (e.by_outline) {
      const bool fitted = pipeline_.parameters().refinement == "photometric" && last->image.psf_sd > 0.0;
      e.template_level = last->image.template_level;
      e.edges = !fitted || side > kSmallCell * pipeline_.search().cells();
    }
    expected.push_back(e);
  }
  return expected;
}

/// As they are expected to stand now; without odometry, their corners alone tell that.
std::map<int, MarkerEstimate> DockTracker::Implementation::lastMarkers(
    const std::optional<Eigen::Isometry3d>& T_now_last) const {
  std::map<int, MarkerEstimate> markers;
  for (MarkerEstimate marker : last_.markers) {
    for (PoseHypothesis& h : marker.hypotheses) h.pose = T_now_last.value_or(Eigen::Isometry3d::Identity()) * h.pose;
    markers.emplace(marker.image.id, marker);
  }
  return markers;
}

DetectionResult DockTracker::Implementation::detect(const cv::Mat& grey,
                                                    const std::optional<Eigen::Isometry3d>& T_now_last) {
  checkImage(grey, pipeline_.camera());
  const auto wanted = parameters_.enabled ? expected(predict(T_now_last)) : std::vector<ExpectedMarker>();
  ImageEstimate estimate;
  std::vector<MarkerCorners> repeated;
  bool full_search = true;
  if (!wanted.empty() && since_full_search_ + 1 < parameters_.full_search_every) {
    estimate = pipeline_.evaluate(pipeline_.search().searchNear(grey, wanted), lastMarkers(T_now_last), last_.tone);
    full_search = estimate.markers.empty();
  }
  if (full_search) {
    const SearchResult found = pipeline_.search().detect(grey, wanted, empty_ % kShadowsEvery == 0);
    doubtful_ = found.doubtful;
    repeated = found.repeated;
    estimate = pipeline_.evaluate(found);
  }
  since_full_search_ = full_search ? 0 : since_full_search_ + 1;
  empty_ = estimate.markers.empty() ? empty_ + 1 : 0;
  before_.clear();
  for (const MarkerEstimate& m : last_.markers) before_[m.image.id] = m.image.corners;
  last_ = estimate;
  DetectionResult result = resultOf(estimate, full_search);
  for (const MarkerCorners& marker : repeated) result.repeated.push_back({marker.id, marker.corners});
  return result;
}

DockTracker::DockTracker(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                         const CameraMount& mount)
    : implementation_(std::make_unique<Implementation>(camera, layout, parameters, mount)) {}

DockTracker::~DockTracker() = default;
DockTracker::DockTracker(DockTracker&&) noexcept = default;

DetectionResult DockTracker::detect(const cv::Mat& grey, const std::optional<Eigen::Isometry3d>& T_now_last) {
  return implementation_->detect(grey, T_now_last);
}

void DockTracker::reset() {
  implementation_->reset();
}

const CameraModel& DockTracker::camera() const {
  return implementation_->camera();
}

}  // namespace seater_perception
