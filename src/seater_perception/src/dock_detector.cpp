#include "seater_perception/dock_detector.h"

#include "seater_perception/image_checks.h"

namespace seater_perception {

DockDetector::DockDetector(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                           const CameraMount& mount)
    : camera_(camera),
      layout_(layout),
      parameters_(parameters),
      up_(mount.upInOptical()),
      detector_(layout.dictionary, parameters.detector) {}

DetectionResult DockDetector::detect(const cv::Mat& grey) const {
  checkPicture(grey, camera_);
  DetectionResult result;
  for (const MarkerCorners& found : detector_.detect(grey)) {
    const auto size = layout_.sizeOf(found.id);
    if (!size) continue;
    PosePrior prior;
    // Only the dock's own markers are known to stand upright.
    if (layout_.markers.count(found.id)) prior.up = up_;
    const auto marker = estimateMarker(camera_, found, *size, prior, parameters_.pose);
    if (marker) {
      result.markers.push_back(*marker);
    } else {
      ++result.refused;
    }
  }
  result.dock = estimateDock(camera_, result.markers, layout_, parameters_.selection, up_, parameters_.pose);
  return result;
}

}  // namespace seater_perception
