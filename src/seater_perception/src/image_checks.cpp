#include "seater_perception/image_checks.h"

#include <array>
#include <opencv2/core.hpp>

#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"

namespace seater_perception {

void checkPicture(const cv::Mat& grey) {
  if (grey.empty()) throw PictureError("the picture is empty");
  if (grey.type() != CV_8UC1) {
    throw PictureError("the picture is of type " + cv::typeToString(grey.type()) + ", must be CV_8UC1 (grey)");
  }
}

void checkPicture(const cv::Mat& grey, const CameraModel& camera) {
  checkPicture(grey);
  if (grey.cols != camera.width() || grey.rows != camera.height()) {
    throw PictureError("the picture is " + std::to_string(grey.cols) + " x " + std::to_string(grey.rows) +
                       ", its calibration is for " + std::to_string(camera.width()) + " x " +
                       std::to_string(camera.height()));
  }
}

void checkEncoding(const std::string& encoding) {
  static const std::array<const char*, 20> known = {
      "mono8",       "mono16",      "bgr8",         "rgb8",         "bgra8",        "rgba8",       "bgr16",
      "rgb16",       "bgra16",      "rgba16",       "yuv422",       "yuv422_yuy2",  "bayer_rggb8", "bayer_bggr8",
      "bayer_gbrg8", "bayer_grbg8", "bayer_rggb16", "bayer_bggr16", "bayer_gbrg16", "bayer_grbg16"};
  for (const char* name : known) {
    if (encoding == name) return;
  }
  throw PictureError("the picture's encoding is '" + encoding +
                     "', must be mono, bgr, rgb, bgra, rgba, yuv422 or bayer of 8 or 16 bits");
}

}  // namespace seater_perception
