#include "image/image_checks.h"

#include <opencv2/core.hpp>

#include "seater_perception/camera_model.h"
#include "seater_perception/errors.h"

namespace seater_perception {

void checkImage(const cv::Mat& grey) {
  if (grey.empty()) throw ImageError("the image is empty");
  if (grey.type() != CV_8UC1) {
    throw ImageError("the image is of type " + cv::typeToString(grey.type()) + ", must be CV_8UC1 (grey)");
  }
}

void checkImage(const cv::Mat& grey, const CameraModel& camera) {
  checkImage(grey);
  if (grey.cols != camera.width() || grey.rows != camera.height()) {
    throw ImageError("the image is " + std::to_string(grey.cols) + " x " + std::to_string(grey.rows) +
                     ", its calibration is for " + std::to_string(camera.width()) + " x " +
                     std::to_string(camera.height()));
  }
}

}  // namespace seater_perception
