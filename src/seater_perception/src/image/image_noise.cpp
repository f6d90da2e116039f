#include "image/image_noise.h"

#include <cstdlib>
#include <limits>
#include <vector>

#include "image/pixel_rect.h"

namespace seater_perception {
namespace {

// [1 -2 1] along both axes: the root of the sum of its squares is 6. Of a normal distribution, the median absolute
// value is 0.6745 standard deviations.
constexpr double kGain = 6.0, kMedian = 0.6745;
constexpr int kSmallest = 5;  // [px]

/// Whole numbers from 0 to `largest`, whose median is wanted.
class Counts {
 public:
  explicit Counts(int largest) : counts_(static_cast<std::size_t>(largest) + 1, 0) {}

  void add(int value) { ++counts_[static_cast<std::size_t>(value)], ++total_; }
  bool empty() const { return total_ == 0; }
  /// Of an even number, the upper one of the two in the middle.
  int median() const {
    int value = 0;
    for (int below = counts_[0]; below <= total_ / 2; below += counts_[static_cast<std::size_t>(value)]) ++value;
    return value;
  }

 private:
  std::vector<int> counts_;
  int total_ = 0;
};

template <typename Pixel>
double noiseOf(const cv::Mat& grey, const cv::Rect& part) {
  constexpr int kBrightest = std::numeric_limits<Pixel>::max();
  Counts responses(8 * kBrightest);
  for (int y = part.y + 1; y + 1 < part.y + part.height; ++y) {
    const Pixel *above = grey.ptr<Pixel>(y - 1), *row = grey.ptr<Pixel>(y), *below = grey.ptr<Pixel>(y + 1);
    const auto down = [=](int x) { return above[x] - 2 * row[x] + below[x]; };
    for (int x = part.x + 1; x + 1 < part.x + part.width; ++x) {
      if (row[x] <= 1 || row[x] + 1 >= kBrightest) continue;
      responses.add(std::abs(down(x - 1) - 2 * down(x) + down(x + 1)));
    }
  }
  return responses.empty() ? 0.0 : responses.median() / (kGain * kMedian);
}

}  // namespace

double whiteNoise(const cv::Mat& grey, const Eigen::AlignedBox2d& part) {
  const cv::Rect rect = pixelRect(grey, part);
  if (rect.width < kSmallest || rect.height < kSmallest) return 0.0;
  return grey.depth() == CV_16U ? noiseOf<ushort>(grey, rect) : noiseOf<uchar>(grey, rect);
}

}  // namespace seater_perception
