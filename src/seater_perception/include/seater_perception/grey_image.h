#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace seater_perception {

/// An image as a camera driver hands it over (the fields of sensor_msgs/Image). The memory stays the caller's.
struct RawImage {
  std::string encoding;     ///< ROS's name of the pixel format
  int width = 0;            ///< [px]
  int height = 0;           ///< [px]
  std::size_t step = 0;     ///< [bytes] from one row to the next
  bool big_endian = false;  ///< byte order of 16-bit pixels
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< [bytes]
};

/// The image in grey, CV_8UC1. mono8 shares the caller's memory, all others are new.
///
/// Encodings: mono, bgr, rgb, bgra, rgba and the four Bayer patterns (bilinear demosaicing), each of 8 and 16 bits;
/// yuv422 (U Y V Y) and yuv422_yuy2 (Y U Y V), of which the luma is taken. Colours weigh 0.299 R + 0.587 G + 0.114 B.
/// 16 bits: see reduceTo8Bits. Throws ImageError for an empty image, one whose size does not fit its data, and for
/// any other encoding (depth and floating-point images show no print), naming it and those that are allowed.
cv::Mat toGrey(const RawImage& image);

/// CV_16UC1 to CV_8UC1, rounded. Cameras of 10, 12 or 14 bits fill the low bits of a 16-bit pixel and do not say how
/// many: the fewest bits b that hold the brightest pixel are taken, so 2^b - 1 becomes 255. Nothing is clipped, a
/// sensor's saturation stays the largest value, and at least half of the 8-bit range is used however dark the image.
/// The factor may change by 2 from image to image: brightness has no meaning here, only contrast.
cv::Mat reduceTo8Bits(const cv::Mat& grey16);

}  // namespace seater_perception
