#include "search/outline/dark_patches.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "search/outline/outline_hull.h"

namespace seater_perception {
namespace {

constexpr int kWord = 8, kMost = 64;  // pixels looked at together, and kept as bits

/// Dark pixels beside each other in a row: from `first` to before `end`.
struct Run {
  int row, first, end, patch;
};

/// A bit for each of at most 64 pixels, the first one lowest: whether it is dark.
std::uint64_t bitsOf(const uchar* pixels, int count) {
  std::uint64_t bits = 0;
  int x = 0;
  for (; x + kWord <= count; x += kWord) {
    std::uint64_t word = 0;
    std::memcpy(&word, pixels + x, sizeof(word));
    // The product collects the bytes' highest bits in its own highest byte, each from where no other one comes.
    bits |= ((word & 0x8080808080808080U) * 0x0002040810204081U >> 56U) << static_cast<unsigned>(x);
  }
  for (; x < count; ++x) bits |= static_cast<std::uint64_t>(pixels[x] >> 7U) << static_cast<unsigned>(x);
  return bits;
}

/// Calls found(first, end) for each run of a row.
template <typename Found>
void eachRun(const uchar* row, int width, const Found& found) {
  int first = 0;
  bool dark = false;
  for (int x = 0; x < width; x += kMost) {
    const int count = std::min(kMost, width - x);
    const std::uint64_t bits = bitsOf(row + x, count);
    // Where a pixel is not as the one before it. What lies beyond the row's end is light.
    for (std::uint64_t change = bits ^ (bits << 1U | (dark ? 1U : 0U)); change != 0; change &= change - 1) {
      const int at = x + __builtin_ctzll(change);
      if (dark) found(first, at);
      first = at;
      dark = !dark;
    }
  }
  if (dark) found(first, width);
}

struct Extent {
  int left, top, right, bottom;  // right and bottom included

  void add(const Extent& e) {
    left = std::min(left, e.left), top = std::min(top, e.top);
    right = std::max(right, e.right), bottom = std::max(bottom, e.bottom);
  }
};

/// Runs and the patches that they are part of.
class Patches {
 public:
  explicit Patches(const cv::Mat& dark) {
    std::size_t above = 0;  // the first run of the row above
    for (int y = 0; y < dark.rows; ++y) {
      const std::size_t here = runs_.size();
      std::size_t next = above;
      eachRun(dark.ptr<uchar>(y), dark.cols, [&](int first, int end) { add({y, first, end, -1}, here, next); });
      above = here;
    }
  }

  const std::vector<Run>& runs() const { return runs_; }
  const Extent& extent(int patch) const { return extents_[static_cast<std::size_t>(patch)]; }
  std::size_t count() const { return parent_.size(); }

  int root(int patch) const {
    int at = patch;
    while (parent_[static_cast<std::size_t>(at)] != at) at = parent_[static_cast<std::size_t>(at)];
    return at;
  }

 private:
  /// `next`: of the row above (which ends at run `here`), the first run that may touch this one or a later one.
  void add(Run run, std::size_t here, std::size_t& next) {
    while (next < here && runs_[next].end < run.first) ++next;
    for (std::size_t i = next; i < here && runs_[i].first <= run.end; ++i)
      run.patch = run.patch < 0 ? root(runs_[i].patch) : united(run.patch, root(runs_[i].patch));
    const Extent extent{run.first, run.row, run.end - 1, run.row};
    if (run.patch < 0) {
      run.patch = static_cast<int>(parent_.size());
      parent_.push_back(run.patch);
      extents_.push_back(extent);
    } else {
      extents_[static_cast<std::size_t>(run.patch)].add(extent);
    }
    runs_.push_back(run);
  }

  /// The older one takes the younger one over, so that a patch is known by its first run.
  int united(int a, int b) {
    if (a == b) return a;
    const int older = std::min(a, b), younger = std::max(a, b);
    parent_[static_cast<std::size_t>(younger)] = older;
    extents_[static_cast<std::size_t>(older)].add(extents_[static_cast<std::size_t>(younger)]);
    return older;
  }

  std::vector<Run> runs_;
  std::vector<int> parent_;
  std::vector<Extent> extents_;
};

/// Steps to the eight neighbours, counter-clockwise from the right one.
constexpr std::array<int, 8> kStepX{1, 1, 0, -1, -1, -1, 0, 1}, kStepY{0, -1, -1, -1, 0, 1, 1, 1};

}  // namespace

std::vector<DarkPatch> darkPatches(const cv::Mat& dark, double least_area) {
  const Patches patches(dark);
  struct Candidate {
    cv::Point first;
    std::vector<RowExtent> rows;
  };
  std::vector<Candidate> candidates;
  constexpr int kNotYet = -1, kNone = -2;
  std::vector<int> number(patches.count(), kNotYet);
  for (const Run& run : patches.runs()) {
    const int root = patches.root(run.patch);
    int& here = number[static_cast<std::size_t>(root)];
    if (here == kNone) continue;
    const Extent& box = patches.extent(root);
    if (here == kNotYet) {
      const double area = static_cast<double>(box.right - box.left) * (box.bottom - box.top);
      const bool inside = box.left > 0 && box.top > 0 && box.right + 1 < dark.cols && box.bottom + 1 < dark.rows;
      here = area < least_area || !inside ? kNone : static_cast<int>(candidates.size());
      if (here == kNone) continue;
      candidates.push_back({{run.first, run.row}, {}});
      candidates.back().rows.resize(static_cast<std::size_t>(box.bottom - box.top + 1));
    }
    candidates[static_cast<std::size_t>(here)].rows[static_cast<std::size_t>(run.row - box.top)].add(run.first,
                                                                                                     run.end - 1);
  }
  std::vector<DarkPatch> result;
  for (const Candidate& c : candidates) result.push_back({c.first, convexHullOf(c.first.y, c.rows)});
  return result;
}

std::vector<cv::Point> outlineOf(const cv::Mat& dark, const cv::Point& first) {
  const auto step = static_cast<std::ptrdiff_t>(dark.step[0]);
  std::array<std::ptrdiff_t, 8> to{};
  for (std::size_t i = 0; i < 8; ++i) to[i] = kStepY[i] * step + kStepX[i];
  const uchar* const start = dark.ptr<uchar>(first.y) + first.x;
  std::vector<cv::Point> outline;
  // The first neighbour, clockwise from the left one, where there is nothing.
  std::size_t s = 3;
  while (s != 4 && start[to[s]] == 0) s = (s + 7) & 7U;
  outline.push_back(first);
  if (s == 4) return outline;
  const uchar* const last = start + to[s];
  const uchar* here = start;
  cv::Point at = first;
  while (true) {
    do s = (s + 1) & 7U;
    while (here[to[s]] == 0);
    const uchar* const next = here + to[s];
    if (next == start && here == last) return outline;
    at += cv::Point(kStepX[s], kStepY[s]);
    outline.push_back(at);
    here = next;
    s = (s + 4) & 7U;
  }
}

}  // namespace seater_perception
