#pragma once

#include <Eigen/Geometry>

namespace cv {
class Mat;
}

namespace seater_perception {

/// Standard deviation of the white noise of a part of an image [grey levels]: by the median absolute response of a
/// second difference along both axes, which plane light and straight edges along them leave out (J. Immerkaer, "Fast
/// noise variance estimation", CVIU 1996; the median instead of the mean, so that texture on less than half of the
/// part hardly counts). Pixels at the end of the range, which has cut their noise off, do not count. What a camera has
/// denoised or coded shows less than its errors are. 0 when the part is smaller than 5 x 5 px, or cut off. `grey` is
/// CV_8UC1 or CV_16UC1.
double whiteNoise(const cv::Mat& grey, const Eigen::AlignedBox2d& part);

}  // namespace seater_perception
