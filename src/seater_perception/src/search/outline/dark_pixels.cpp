#include "search/outline/dark_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "numerics/vector_clones.h"

namespace seater_perception {
namespace {

// Half a pixel inside a blurred step (sd 0.8 px), a 5 px window's mean is 0.16 of the step lighter; half of that is
// asked for. Chosen with drawn grey prints (docs/results/photographs.md, Another maker's cameras); with 0.12 a
// sixth of them is lost.
constexpr double kPartOfStep = 0.08;
constexpr double kLeastConstant = 3.0;  // [grey levels] as much as noise of sd 1 reaches
// Noise of sd 5 on flat paper differs by as much within the window. Chosen by hand; with 20 none more is found.
constexpr double kFlat = 25.0;  // [grey levels]
constexpr int kStepWindow = 7;  // [px] holds both sides of a blurred step
constexpr int kStrip = 64;      // [rows]

cv::Mat tableOfLimits(double constant) {
  cv::Mat table(1, 256, CV_8U);
  for (int step = 0; step < 256; ++step) {
    const double limit = std::clamp(std::rint(kPartOfStep * step), std::min(kLeastConstant, constant), constant);
    table.at<uchar>(step) = cv::saturate_cast<uchar>(std::floor(step < kFlat ? constant : limit));
  }
  return table;
}

/// As cv::adaptiveThreshold, but by how much darker a pixel has to be follows from how much grey levels differ round
/// it. Strip by strip, so that nothing leaves the processor's cache in between.
cv::Mat faintToo(const cv::Mat& seen, const DarkPixels& what) {
  const cv::Mat table = tableOfLimits(what.constant), step = cv::Mat::ones(kStepWindow, kStepWindow, CV_8U);
  const int reach = std::max(what.window, kStepWindow) / 2;
  const int border = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;
  cv::Mat dark(seen.size(), CV_8U), mean, darker, most, least, limits;
  for (int first = 0; first < seen.rows; first += kStrip) {
    const int last = std::min(seen.rows, first + kStrip), above = std::max(0, first - reach);
    const cv::Mat part = seen.rowRange(above, std::min(seen.rows, last + reach));
    cv::boxFilter(part, mean, CV_8U, cv::Size(what.window, what.window), cv::Point(-1, -1), true, border);
    cv::subtract(mean, part, darker);
    cv::dilate(part, most, step, cv::Point(-1, -1), 1, border);
    cv::erode(part, least, step, cv::Point(-1, -1), 1, border);
    cv::subtract(most, least, limits);
    cv::LUT(limits, table, limits);
    const cv::Range inner(first - above, last - above);
    cv::Mat to = dark.rowRange(first, last);
    cv::compare(darker.rowRange(inner), limits.rowRange(inner), to, cv::CMP_GE);
  }
  return dark;
}

SEATER_VECTOR_CLONES void addDifference(const uchar* plus, const uchar* minus, int n, int* __restrict sums) {
  for (int i = 0; i < n; ++i) sums[i] += plus[i] - minus[i];
}

/// Where twice the window's sum, before[i + window] - before[i], is at least `area` (2 (grey + constant) - 1).
SEATER_VECTOR_CLONES void compare(const uchar* grey, const int* before, int window, int constant, int n,
                                  uchar* __restrict dark) {
  const int area = window * window, *behind = before + window;
  for (int i = 0; i < n; ++i) {
    const int least = area * (2 * (grey[i] + constant) - 1);
    dark[i] = 2 * (behind[i] - before[i]) >= least ? 255 : 0;
  }
}

/// Mean of three rows and columns, rounded, of the columns 1 .. n - 2.
SEATER_VECTOR_CLONES void smooth(const uchar* above, const uchar* here, const uchar* below, int n,
                                 std::uint16_t* __restrict sums, uchar* __restrict mean) {
  for (int i = 0; i < n; ++i) sums[i] = static_cast<std::uint16_t>(above[i] + here[i] + below[i]);
  for (int i = 1; i < n - 1; ++i) {
    const unsigned sum = static_cast<unsigned>(sums[i - 1]) + sums[i] + sums[i + 1];
    mean[i] = static_cast<uchar>((sum * 7282U + 32768U) >> 16U);  // 7282 / 65536: 1 / 9, near enough for any sum
  }
}

/// The rows of an image as they are, or smoothed: the last ones of them are kept, as many as a window has and two.
class Rows {
 public:
  Rows(const cv::Mat& grey, int window, bool smoothed)
      : grey_(grey), smoothed_(smoothed), sums_(static_cast<std::size_t>(grey.cols)) {
    if (smoothed) kept_.create(window + 2, grey.cols, CV_8U);
  }

  /// Beyond the image, its outermost rows. Rows have to be asked for in their order, first of all the first.
  const uchar* at(int y) {
    y = std::clamp(y, 0, grey_.rows - 1);
    if (!smoothed_) return grey_.ptr<uchar>(y);
    for (; made_ <= y; ++made_) make(made_);
    return kept_.ptr<uchar>(y % kept_.rows);
  }

 private:
  void make(int y) {
    const int last = grey_.cols - 1;
    uchar* mean = kept_.ptr<uchar>(y % kept_.rows);
    smooth(grey_.ptr<uchar>(std::max(0, y - 1)), grey_.ptr<uchar>(y), grey_.ptr<uchar>(std::min(grey_.rows - 1, y + 1)),
           grey_.cols, sums_.data(), mean);
    const auto ninth = [](int sum) { return static_cast<uchar>((2 * sum + 9) / 18); };
    mean[0] = ninth(2 * sums_[0] + sums_[1]);
    mean[last] = ninth(2 * sums_[static_cast<std::size_t>(last)] + sums_[static_cast<std::size_t>(last) - 1]);
  }

  const cv::Mat& grey_;
  const bool smoothed_;
  std::vector<std::uint16_t> sums_;
  cv::Mat kept_;
  int made_ = 0;
};

/// As cv::blur and cv::adaptiveThreshold, to the last pixel, in a third of the time: nothing but the result is stored.
cv::Mat adaptive(const cv::Mat& grey, const DarkPixels& what) {
  const int reach = what.window / 2, width = grey.cols, constant = static_cast<int>(std::floor(what.constant));
  Rows rows(grey, what.window, what.smooth);
  const std::vector<uchar> none(static_cast<std::size_t>(width), 0);
  std::vector<int> sums(static_cast<std::size_t>(width), 0);  // of the window's rows
  for (int y = -reach - 1; y < reach; ++y) addDifference(rows.at(y), none.data(), width, sums.data());
  std::vector<int> before(static_cast<std::size_t>(width + 2 * reach + 1), 0);  // of all columns further left
  cv::Mat dark(grey.size(), CV_8U);
  for (int y = 0; y < grey.rows; ++y) {
    const uchar* const next_row = rows.at(y + reach);
    addDifference(next_row, rows.at(y - reach - 1), width, sums.data());
    int sum = 0;
    int* next = before.data();
    for (int i = 0; i < reach; ++i) *++next = sum += sums.front();
    for (const int s : sums) *++next = sum += s;
    for (int i = 0; i < reach; ++i) *++next = sum += sums.back();
    compare(rows.at(y), before.data(), what.window, constant, width, dark.ptr<uchar>(y));
  }
  return dark;
}

}  // namespace

cv::Mat darkPixels(const cv::Mat& grey, const DarkPixels& what) {
  if (!what.faint) return adaptive(grey, what);
  if (!what.smooth) return faintToo(grey, what);
  cv::Mat smooth;
  cv::blur(grey, smooth, cv::Size(3, 3), cv::Point(-1, -1), cv::BORDER_REPLICATE);
  return faintToo(smooth, what);
}

}  // namespace seater_perception
