#include "image/image_noise.h"

#include <array>
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
  explicit Counts(int largest) : counts_(static_cast<std::size_t>(largest) + 1, {0, 0}) {}

  /// `k` counts them: neighbours are often equal, and by turns in two tables neither waits for the other.
  void add(int value, int k) { ++counts_[static_cast<std::size_t>(value)][static_cast<std::size_t>(k % 2)], ++total_; }
  bool empty() const { return total_ == 0; }
  /// Of an even number, the upper one of the two in the middle.
  int median() const {
    int value = -1;
    for (int below = 0; below <= total_ / 2;) {
      const auto& both = counts_[static_cast<std::size_t>(++value)];
      below += both[0] + both[1];
    }
    return value;
  }

 private:
  std::vector<std::array<int, 2>> counts_;
  int total_ = 0;
};

/// |[1 -2 1] along both axes| of three rows, but for their first and last pixels.
template <typename Pixel>
void respond(const Pixel* above, const Pixel* row, const Pixel* below, int count, int* out) {
  for (int x = 1; x + 1 < count; ++x) {
    const int before = above[x - 1] - 2 * row[x - 1] + below[x - 1];
    const int at = above[x] - 2 * row[x] + below[x];
    const int after = above[x + 1] - 2 * row[x + 1] + below[x + 1];
    out[x] = std::abs(before - 2 * at + after);
  }
}

template <typename Pixel>
double noiseOf(const cv::Mat& grey, const cv::Rect& part) {
  constexpr int kBrightest = std::numeric_limits<Pixel>::max();
  Counts counts(8 * kBrightest);
  std::vector<int> responses(static_cast<std::size_t>(part.width));
  for (int y = part.y + 1; y + 1 < part.y + part.height; ++y) {
    const auto rowAt = [&](int v) { return grey.ptr<Pixel>(v) + part.x; };
    const Pixel* row = rowAt(y);
    respond(rowAt(y - 1), row, rowAt(y + 1), part.width, responses.data());
    for (int x = 1; x + 1 < part.width; ++x) {
      if (row[x] > 1 && row[x] + 1 < kBrightest) counts.add(responses[static_cast<std::size_t>(x)], x);
    }
  }
  return counts.empty() ? 0.0 : counts.median() / (kGain * kMedian);
}

}  // namespace

double whiteNoise(const cv::Mat& grey, const Eigen::AlignedBox2d& part) {
  const cv::Rect rect = pixelRect(grey, part);
  if (rect.width < kSmallest || rect.height < kSmallest) return 0.0;
  return grey.depth() == CV_16U ? noiseOf<ushort>(grey, rect) : noiseOf<uchar>(grey, rect);
}

}  // namespace seater_perception
