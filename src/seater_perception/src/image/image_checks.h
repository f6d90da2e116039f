#pragma once

namespace cv {
class Mat;
}

namespace seater_perception {

class CameraModel;

/// Throws PictureError unless the picture is CV_8UC1 and not empty.
void checkPicture(const cv::Mat& grey);

/// As above, and throws PictureError when the picture's size is not the calibration's.
void checkPicture(const cv::Mat& grey, const CameraModel& camera);

}  // namespace seater_perception
