#include "image/image_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "image/pixel_rect.h"

namespace seater_perception {
namespace {

// [1 -2 1] along both axes: the root of the sum of its squares is 6. Of a normal distribution, the median absolute
// value is 0.6745 standard deviations.
constexpr double kGain = 6.0, kMedian = 0.6745;
constexpr int kSmallest = 5;  // [px]

template <typename Pixel>
double noiseOf(const cv::Mat& grey, const cv::Rect& part) {
  std::vector<float> responses;
  responses.reserve(static_cast<std::size_t>(part.area()));
  for (int y = part.y + 1; y + 1 < part.y + part.height; ++y) {
    const Pixel* rows[] = {grey.ptr<Pixel>(y - 1), grey.ptr<Pixel>(y), grey.ptr<Pixel>(y + 1)};
    const auto across = [](const Pixel* row, int x) {
      return static_cast<float>(row[x - 1]) - 2.0F * static_cast<float>(row[x]) + static_cast<float>(row[x + 1]);
    };
    for (int x = part.x + 1; x + 1 < part.x + part.width; ++x) {
      if (rows[1][x] <= 1 || rows[1][x] + 1 >= std::numeric_limits<Pixel>::max()) continue;
      responses.push_back(std::abs(across(rows[0], x) - 2.0F * across(rows[1], x) + across(rows[2], x)));
    }
  }
  if (responses.empty()) return 0.0;
  const auto middle = responses.begin() + static_cast<std::ptrdiff_t>(responses.size() / 2);
  std::nth_element(responses.begin(), middle, responses.end());
  return static_cast<double>(*middle) / (kGain * kMedian);
}

}  // namespace

double whiteNoise(const cv::Mat& grey, const Eigen::AlignedBox2d& part) {
  const cv::Rect rect = pixelRect(grey, part);
  if (rect.width < kSmallest || rect.height < kSmallest) return 0.0;
  return grey.depth() == CV_16U ? noiseOf<ushort>(grey, rect) : noiseOf<uchar>(grey, rect);
}

}  // namespace seater_perception
