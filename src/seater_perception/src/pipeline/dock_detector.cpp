#include "seater_perception/dock_detector.h"

#include "image/image_checks.h"
#include "pipeline/detection_pipeline.h"

namespace seater_perception {

struct DockDetector::Implementation {
  DetectionPipeline pipeline;
};

DockDetector::DockDetector(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                           const CameraMount& mount)
    : implementation_(new Implementation{DetectionPipeline(camera, layout, parameters, mount)}) {}

DockDetector::~DockDetector() = default;
DockDetector::DockDetector(DockDetector&&) noexcept = default;

DetectionResult DockDetector::detect(const cv::Mat& grey) {
  DetectionPipeline& pipeline = implementation_->pipeline;
  checkImage(grey, pipeline.camera());
  const SearchResult found = pipeline.search().detect(grey);
  DetectionResult result = resultOf(pipeline.evaluate(found), true);
  for (const MarkerCorners& marker : found.repeated) result.repeated.push_back({marker.id, marker.corners});
  return result;
}

const CameraModel& DockDetector::camera() const {
  return implementation_->pipeline.camera();
}

const DockLayout& DockDetector::layout() const {
  return implementation_->pipeline.layout();
}

}  // namespace seater_perception
