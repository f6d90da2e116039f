#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"
#include "seater_perception/dock_layout.h"

namespace seater_perception {

/// A colour image (CV_8UC3, bgr) for people: the grey image with each marker's outline, id and axes (x red, y
/// green, z blue; a red ring on the print's top left corner), the dock's axes, and on top one line of text for each
/// marker and the dock, then `lines`.
cv::Mat annotate(const cv::Mat& grey, const CameraModel& camera, const DockLayout& layout,
                 const DetectionResult& result, const std::vector<std::string>& lines = {});

}  // namespace seater_perception
