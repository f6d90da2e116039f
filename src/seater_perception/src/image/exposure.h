#pragma once

#include <Eigen/Geometry>

namespace cv {
class Mat;
}

namespace seater_perception {

/// Of the pixels of a part of an image that are lighter than halfway between its darkest and its lightest one, the part
/// at the end of the range: 0 .. 1. There it is not known how light the paper is, and its light grows into the ink
/// (bloom). 0 when nothing of the part is in the image. `grey` is CV_8UC1 or CV_16UC1 (end of the range: 65535).
double whiteCutOff(const cv::Mat& grey, const Eigen::AlignedBox2d& part);

}  // namespace seater_perception
