#pragma once

#include <string>

namespace cv {
class Mat;
}

namespace seater_perception {

class CameraModel;

/// Throws PictureError unless the picture is CV_8UC1 and not empty.
void checkPicture(const cv::Mat& grey);

/// As above, and throws PictureError when the picture's size is not the calibration's.
void checkPicture(const cv::Mat& grey, const CameraModel& camera);

/// Throws PictureError for an image encoding (ROS's name of it) that is not a grey or colour picture of 8 or 16 bits:
/// depth pictures and floating-point ones are not pictures of a marker.
void checkEncoding(const std::string& encoding);

}  // namespace seater_perception
