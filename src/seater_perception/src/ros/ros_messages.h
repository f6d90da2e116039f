#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <seater_msgs/MarkerDetectionArray.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"

namespace seater_perception {

/// Throws CalibrationError for binning and for a region of interest smaller than the image (K would not fit the
/// image).
Calibration toCalibration(const sensor_msgs::CameraInfo& info);

/// The image in grey, CV_8UC1; shares the message's memory where it can, so the message has to outlive it. Both throw
/// ImageError.
cv::Mat toGrey(const sensor_msgs::Image& message);
cv::Mat toGrey(const sensor_msgs::CompressedImage& message);

/// Without processing_time.
seater_msgs::MarkerDetectionArray toMessage(const DetectionResult& result, const std_msgs::Header& header);

geometry_msgs::PoseWithCovariance toMessage(const PoseHypothesis& hypothesis);

}  // namespace seater_perception
