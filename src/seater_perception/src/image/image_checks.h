#pragma once

namespace cv {
class Mat;
}

namespace seater_perception {

class CameraModel;

/// Throws ImageError unless the image is CV_8UC1 and not empty.
void checkImage(const cv::Mat& grey);

/// As above, and throws ImageError when the image's size is not the calibration's.
void checkImage(const cv::Mat& grey, const CameraModel& camera);

}  // namespace seater_perception
