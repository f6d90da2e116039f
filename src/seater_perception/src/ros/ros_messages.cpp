#include "ros_messages.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>

#include "seater_perception/errors.h"
#include "seater_perception/grey_image.h"

namespace seater_perception {
namespace {

using seater_msgs::MarkerDetection;
static_assert(static_cast<int>(PoseStage::corners) == MarkerDetection::CORNERS &&
                  static_cast<int>(PoseStage::edges) == MarkerDetection::EDGES &&
                  static_cast<int>(PoseStage::photometric) == MarkerDetection::PHOTOMETRIC,
              "stages are numbered as in the message");

}  // namespace

Calibration toCalibration(const sensor_msgs::CameraInfo& info) {
  if (info.binning_x > 1 || info.binning_y > 1) {
    throw CalibrationError("camera_info has binning, which is not supported; give the images' own calibration");
  }
  const auto& roi = info.roi;
  const bool whole = (roi.width == 0 || roi.width == info.width) && (roi.height == 0 || roi.height == info.height);
  if (!whole || roi.x_offset != 0 || roi.y_offset != 0) {
    throw CalibrationError(
        "camera_info has a region of interest, which is not supported; give the images' own calibration");
  }
  Calibration c;
  c.width = static_cast<int>(info.width);
  c.height = static_cast<int>(info.height);
  std::copy(info.K.begin(), info.K.end(), c.K.begin());
  std::copy(info.P.begin(), info.P.end(), c.P.begin());
  c.D = info.D;
  c.distortion_model = info.distortion_model;
  return c;
}

cv::Mat toGrey(const sensor_msgs::Image& message) {
  RawImage image;
  image.encoding = message.encoding;
  image.width = static_cast<int>(message.width);
  image.height = static_cast<int>(message.height);
  image.step = message.step;
  image.big_endian = message.is_bigendian != 0;
  image.data = message.data.data();
  image.size = message.data.size();
  return toGrey(image);
}

cv::Mat toGrey(const sensor_msgs::CompressedImage& message) {
  if (message.data.empty()) throw ImageError("the compressed image is empty");
  cv::Mat grey;  // of 8 bits, or (PNG) 16
  try {
    grey = cv::imdecode(message.data, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  } catch (const cv::Exception&) {
    // as good as unreadable
  }
  if (grey.depth() == CV_16U && !grey.empty()) grey = reduceTo8Bits(grey);
  if (grey.empty() || grey.type() != CV_8UC1) {
    throw ImageError("the compressed image ('" + message.format + "') cannot be decoded");
  }
  return grey;
}

geometry_msgs::PoseWithCovariance toMessage(const PoseHypothesis& hypothesis) {
  geometry_msgs::PoseWithCovariance message;
  const Eigen::Vector3d& t = hypothesis.pose.translation();
  const Eigen::Quaterniond q(hypothesis.pose.linear());
  message.pose.position.x = t.x();
  message.pose.position.y = t.y();
  message.pose.position.z = t.z();
  message.pose.orientation.x = q.x();
  message.pose.orientation.y = q.y();
  message.pose.orientation.z = q.z();
  message.pose.orientation.w = q.w();
  std::copy_n(hypothesis.covariance.data(), 36,
              message.covariance.begin());  // symmetric: row or column order is the same
  return message;
}

seater_msgs::MarkerDetectionArray toMessage(const DetectionResult& result, const std_msgs::Header& header) {
  seater_msgs::MarkerDetectionArray message;
  message.header = header;
  for (const DetectedMarker& m : result.markers) {
    seater_msgs::MarkerDetection marker;
    marker.id = m.id;
    marker.size = m.size;
    for (std::size_t i = 0; i < 4; ++i) {
      marker.corners[i].x = m.corners[i].x();
      marker.corners[i].y = m.corners[i].y();
    }
    PoseHypothesis pose = m.best();
    pose.covariance = m.covariance();  // the message holds one pose only
    marker.pose = toMessage(pose);
    marker.reprojection_error = m.best().error;
    marker.ambiguity = m.ambiguity;
    marker.side_px = m.side;
    marker.stage = static_cast<std::uint8_t>(m.stage);
    message.markers.push_back(marker);
  }
  for (const DockHypothesis& h : result.dock) {
    seater_msgs::DockObservation dock;
    dock.pose = toMessage(h);
    dock.weight = h.weight;
    dock.marker_ids.assign(h.marker_ids.begin(), h.marker_ids.end());
    message.dock.push_back(dock);
  }
  return message;
}

}  // namespace seater_perception
