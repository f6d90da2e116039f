#pragma once

#include <opencv2/core.hpp>

namespace seater_perception {

/// Which pixels count as dark.
struct DarkPixels {
  int window = 25;        ///< [px] of the mean, odd
  double constant = 4.0;  ///< [grey levels] how much darker than the window's mean
  bool smooth = true;     ///< by a 3 x 3 window before: noise makes no outlines, but thin light lines vanish
  bool faint = false;     ///< where grey levels differ little, but more than by noise, a smaller `constant` suffices
};

/// Adaptive threshold of a CV_8UC1 image: 255 where it is dark, else 0.
cv::Mat darkPixels(const cv::Mat& grey, const DarkPixels& what);

}  // namespace seater_perception
