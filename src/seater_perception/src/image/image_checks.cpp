#include "image/image_checks.h"

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

}  // namespace seater_perception
