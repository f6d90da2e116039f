#include "image/exposure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/pixel_rect.h"

namespace seater_perception {
namespace {

constexpr double kRange = 255.0;

template <typename Pixel>
double cutOff(const cv::Mat& part) {
  double dark = 0.0, light = 0.0;
  cv::minMaxLoc(part, &dark, &light);
  const double middle = 0.5 * (dark + light);
  int white = 0, cut = 0;
  for (int y = 0; y < part.rows; ++y) {
    const Pixel* row = part.ptr<Pixel>(y);
    for (int x = 0; x < part.cols; ++x) {
      white += static_cast<double>(row[x]) > middle ? 1 : 0;
      cut += row[x] == std::numeric_limits<Pixel>::max() ? 1 : 0;
    }
  }
  return white > 0 ? static_cast<double>(cut) / white : 0.0;
}

}  // namespace

double whiteCutOff(const cv::Mat& grey, const Eigen::AlignedBox2d& part) {
  const cv::Rect rect = pixelRect(grey, part);
  if (rect.empty()) return 0.0;
  return grey.depth() == CV_16U ? cutOff<ushort>(grey(rect)) : cutOff<uchar>(grey(rect));
}

double lightOf(double grey, double exponent) {
  return std::pow(std::max(0.0, grey), exponent);
}

double levelInLight(double grey, double exponent) {
  return kRange * lightOf(grey / kRange, exponent);
}

cv::Mat inLight(const cv::Mat& grey, double exponent) {
  if (exponent == 1.0) return grey;
  cv::Mat table(1, 256, CV_8U), light;
  for (int i = 0; i < 256; ++i) table.at<uchar>(i) = cv::saturate_cast<uchar>(levelInLight(i, exponent));
  cv::LUT(grey, table, light);
  return light;
}

}  // namespace seater_perception
