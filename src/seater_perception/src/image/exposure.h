#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>

namespace seater_perception {

/// Of the pixels of a part of an image that are lighter than halfway between its darkest and its lightest one, the part
/// at the end of the range: 0 .. 1. There it is not known how light the paper is, and its light grows into the ink
/// (bloom). 0 when nothing of the part is in the image. `grey` is CV_8UC1 or CV_16UC1 (end of the range: 65535).
double whiteCutOff(const cv::Mat& grey, const Eigen::AlignedBox2d& part);

/// Light is grey levels to the power of one of these, or as they are (drawn images). A lens blurs light; a camera's
/// tone curve comes after it (about 1 / 2.2: ITU-R BT.709, IEC 61966-2-1; curves of less contrast lie between). In grey
/// levels white has then grown into black by some tenths of a pixel.
constexpr std::array<double, 2> kToneExponents{1.5, 2.2};

/// `grey` and light as a part of the range's end.
double lightOf(double grey, double exponent);

/// The same of a grey level of 0 .. 255, as a level of that range, not rounded.
double levelInLight(double grey, double exponent);

/// An image of grey levels (CV_8UC1) in light. The ends of the range stay where they are. Shares memory for 1.
cv::Mat inLight(const cv::Mat& grey, double exponent);

}  // namespace seater_perception
