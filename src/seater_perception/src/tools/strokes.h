// What drawings on images have in common.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <opencv2/core.hpp>

namespace seater_perception {

const cv::Scalar kOutline(0, 220, 255), kRed(40, 40, 255);
constexpr int kShift = 4;  // OpenCV takes 1/16 px

/// A pixel as OpenCV takes it with kShift.
inline cv::Point fine(const Eigen::Vector2d& p) {
  return {cvRound(p.x() * (1 << kShift)), cvRound(p.y() * (1 << kShift))};
}

/// By which what is drawn is larger than on an image of 1280 columns.
inline double strokeScale(const cv::Mat& image) {
  return std::max(0.5, image.cols / 1280.0);
}

/// [px]
inline int strokeWidth(double wanted) {
  return std::max(1, cvRound(wanted));
}

}  // namespace seater_perception
