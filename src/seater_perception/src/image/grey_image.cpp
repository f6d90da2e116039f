#include "seater_perception/grey_image.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

/// How one encoding is stored and brought to grey.
struct Format {
  const char* encoding;
  int type;        // of OpenCV
  int conversion;  // cv::cvtColor's code; kNone: is grey already; kLuma0, kLuma1: that channel is the luma
};

constexpr int kNone = -1, kLuma0 = -2, kLuma1 = -3;

// OpenCV names a Bayer pattern by the second and third pixel of its second row: RGGB is its "BG".
constexpr std::array<Format, 20> kFormats = {{
    {"mono8", CV_8UC1, kNone},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
    {"yuv422", CV_8UC2, kLuma1},
    {"yuv422_yuy2", CV_8UC2, kLuma0},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
    {"mono16", CV_16UC1, kNone},
    {"bgr16", CV_16UC3, cv::COLOR_BGR2GRAY},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2GRAY},
    {"bgra16", CV_16UC4, cv::COLOR_BGRA2GRAY},
    {"rgba16", CV_16UC4, cv::COLOR_RGBA2GRAY},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY},
}};

const Format& formatOf(const std::string& encoding) {
  std::string allowed;
  for (const Format& format : kFormats) {
    if (encoding == format.encoding) return format;
    allowed += std::string(allowed.empty() ? "" : ", ") + format.encoding;
  }
  throw ImageError("the image's encoding is '" + encoding + "', must be one of " + allowed);
}

bool isBayer(const Format& format) {
  return std::string(format.encoding).rfind("bayer", 0) == 0;
}

/// A view of the caller's memory, after all that could lead outside of it is excluded.
cv::Mat viewOf(const RawImage& p, const Format& format) {
  if (p.width <= 0 || p.height <= 0 || !p.data || p.size == 0) throw ImageError("the image is empty");
  const std::size_t row = static_cast<std::size_t>(p.width) * static_cast<std::size_t>(CV_ELEM_SIZE(format.type));
  // The last row may end with its last pixel.
  if (p.step < row || p.size < p.step * (static_cast<std::size_t>(p.height) - 1) + row) {
    throw ImageError("the image is " + std::to_string(p.width) + " x " + std::to_string(p.height) + " in " +
                     p.encoding + ", which does not fit its rows of " + std::to_string(p.step) + " bytes and " +
                     std::to_string(p.size) + " bytes of data");
  }
  if (p.step % static_cast<std::size_t>(CV_ELEM_SIZE1(format.type)) != 0) {
    throw ImageError("the image's rows of " + std::to_string(p.step) + " bytes do not hold whole values of " +
                     p.encoding);
  }
  if (isBayer(format) && (p.width < 3 || p.height < 3)) {
    throw ImageError("the image is " + std::to_string(p.width) + " x " + std::to_string(p.height) + " in " +
                     p.encoding + ", must be at least 3 x 3");
  }
  // cv::Mat takes no const memory; nothing here writes to it.
  return {p.height, p.width, format.type, const_cast<std::uint8_t*>(p.data), p.step};
}

bool machineIsBigEndian() {
  const std::uint16_t one = 1;
  return *reinterpret_cast<const std::uint8_t*>(&one) == 0;
}

/// A copy in this machine's byte order.
cv::Mat swapped(const cv::Mat& image) {
  cv::Mat result(image.size(), image.type());
  const int values = image.cols * image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const auto* from = image.ptr<std::uint16_t>(y);
    auto* to = result.ptr<std::uint16_t>(y);
    std::transform(from, from + values, to,
                   [](std::uint16_t v) { return static_cast<std::uint16_t>((v << 8) | (v >> 8)); });
  }
  return result;
}

cv::Mat converted(const cv::Mat& image, int conversion) {
  cv::Mat grey;
  if (conversion == kLuma0 || conversion == kLuma1) {
    cv::extractChannel(image, grey, conversion == kLuma0 ? 0 : 1);
  } else {
    cv::cvtColor(image, grey, conversion);
  }
  return grey;
}

}  // namespace

cv::Mat reduceTo8Bits(const cv::Mat& grey16) {
  CV_Assert(grey16.type() == CV_16UC1);
  double brightest = 0.0;
  cv::minMaxLoc(grey16, nullptr, &brightest);
  int bits = 8;  // never brighter than it came
  while (bits < 16 && brightest > (1 << bits) - 1) ++bits;
  cv::Mat grey;
  grey16.convertTo(grey, CV_8U, 255.0 / ((1 << bits) - 1));
  return grey;
}

cv::Mat toGrey(const RawImage& image) {
  const Format& format = formatOf(image.encoding);
  cv::Mat grey = viewOf(image, format);
  if (grey.depth() == CV_16U && image.big_endian != machineIsBigEndian()) grey = swapped(grey);
  if (format.conversion != kNone) {
    try {
      grey = converted(grey, format.conversion);
    } catch (const cv::Exception& error) {
      throw ImageError("the image cannot be converted from " + image.encoding + ": " + error.what());
    }
  }
  return grey.depth() == CV_16U ? reduceTo8Bits(grey) : grey;
}

}  // namespace seater_perception
