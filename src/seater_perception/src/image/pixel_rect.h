// The pixels of a box in an image.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/core.hpp>

namespace seater_perception {

/// All pixels of `grey` that `part` [px] touches or borders on; empty where it is out of the image.
inline cv::Rect pixelRect(const cv::Mat& grey, const Eigen::AlignedBox2d& part) {
  const auto whole = [](double x, int limit) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(limit)));
  };
  return {cv::Point(whole(part.min().x(), grey.cols), whole(part.min().y(), grey.rows)),
          cv::Point(whole(part.max().x() + 1.0, grey.cols), whole(part.max().y() + 1.0, grey.rows))};
}

}  // namespace seater_perception
