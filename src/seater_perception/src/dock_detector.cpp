#include "seater_perception/dock_detector.h"

#include <algorithm>

#include "seater_perception/image_checks.h"

namespace seater_perception {

namespace {

/// Only what is not in the layout can be left out of the search.
std::set<int> idsOf(const DockLayout& layout) {
  std::set<int> ids;
  if (layout.size_of_others) return ids;
  for (const auto& [id, marker] : layout.markers) ids.insert(id);
  return ids;
}

/// Of a marker's hypotheses, the one whose attitude is nearest to this pose's.
void keepNearest(const Eigen::Isometry3d& pose, DetectedMarker& marker) {
  const auto turn = [&pose](const PoseHypothesis& h) {
    return Eigen::AngleAxisd(h.pose.linear().transpose() * pose.linear()).angle();
  };
  PoseHypothesis nearest = *std::min_element(marker.hypotheses.begin(), marker.hypotheses.end(),
                                             [&](const auto& a, const auto& b) { return turn(a) < turn(b); });
  nearest.weight = 1.0;
  marker.hypotheses = {nearest};
  marker.branch_known = true;
}

}  // namespace

DockDetector::DockDetector(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                           const CameraMount& mount)
    : camera_(camera),
      layout_(layout),
      parameters_(parameters),
      up_(mount.upInOptical()),
      detector_(layout.dictionary, parameters.detector, idsOf(layout)),
      refiner_(parameters.photometric),
      patterns_(layout.dictionary) {}

DetectionResult DockDetector::detect(const cv::Mat& grey) const {
  checkPicture(grey, camera_);
  return evaluate(grey, detector_.detect(grey));
}

DetectionResult DockDetector::evaluate(const cv::Mat& grey, const std::vector<MarkerCorners>& found) const {
  checkPicture(grey, camera_);
  DetectionResult result;
  for (const MarkerCorners& corners : found) {
    const auto size = layout_.sizeOf(corners.id);
    if (!size) continue;
    const auto marker = estimateMarker(camera_, corners, *size, priorOf(corners.id), parameters_.pose);
    if (marker) {
      result.markers.push_back(*marker);
    } else {
      ++result.refused;
    }
  }
  const bool photometric = parameters_.refinement == "photometric";
  if (photometric) refineMarkers(grey, result);
  result.dock = estimateDock(camera_, result.markers, layout_, parameters_.selection, up_, parameters_.pose);
  if (photometric) {
    refineBundle(grey, camera_, patterns_, refiner_, layout_, up_, parameters_.pose, result.markers, result.dock);
  }
  addPlacementError(camera_, layout_, parameters_.pose.placement_sigma, result.dock);
  return result;
}

PosePrior DockDetector::priorOf(int id) const {
  PosePrior prior;
  // Only the dock's own markers are known to stand upright.
  if (layout_.markers.count(id)) prior.up = up_;
  return prior;
}

void DockDetector::refineMarkers(const cv::Mat& grey, DetectionResult& result) const {
  const auto dock = estimateDock(camera_, result.markers, layout_, "bundle", up_, parameters_.pose);
  std::vector<DetectedMarker> kept;
  for (DetectedMarker& marker : result.markers) {
    const int id = marker.image.id;
    // Where several markers together leave one pose of the dock only, each one's branch is known.
    if (dock.size() == 1 && dock.front().marker_ids.size() > 1 && layout_.markers.count(id)) {
      keepNearest(dock.front().pose * layout_.markers.at(id).T_dock_marker(), marker);
    }
    const bool fitted =
        refinePhotometrically(grey, camera_, patterns_.of(id), refiner_, priorOf(id), parameters_.pose, marker);
    // The own search is generous with outlines: the grey levels have to prove the code.
    const bool proved = fitted && marker.image.side() >= parameters_.detector.min_side;
    if (!proved && parameters_.detector.search == "own") {
      ++result.refused;
    } else {
      kept.push_back(marker);
    }
  }
  result.markers = kept;
}

}  // namespace seater_perception
