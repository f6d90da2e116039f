#include "search/code/image_levels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "numerics/vector_clones.h"

namespace seater_perception {
namespace {

constexpr double kMargin = 0.25;  // [sides] of the region round a print: the quiet zone and some more
// A bilinear sample sees about 1 px: four of them see about a quarter of a cell of 4 px, which they stand for.
constexpr double kSeveralFrom = 4.0;  // [px] of a cell: four points round each of the grid, at a level with such cells
// Two points at +-0.14 have a standard deviation of 0.14 cells, that of a half cell's width (0.5 / sqrt(12)): together
// they stand for their quarter of the cell, and what blur they find is the print's own.
constexpr float kApart = 0.14f;  // [cells] these from that, to each side
// More levels than any image needs; a level of less than 24 px could not hold a print with its quiet zone.
constexpr int kMostLevels = 8, kSmallestLevel = 24;
// Of the homography's third coordinate, 1 in the print's first corner: below, the plane runs off behind the camera.
constexpr float kNearestPlane = 0.05f;

}  // namespace

ImageLevels::ImageLevels(const cv::Mat& grey) {
  levels_.push_back(grey);
  for (int length = std::min(grey.cols, grey.rows); most_ < kMostLevels && length >= 2 * kSmallestLevel; ++most_)
    length = (length + 1) / 2;
}

const cv::Mat& ImageLevels::level(std::size_t number) const {
  while (levels_.size() <= number) {
    cv::Mat coarser;
    cv::pyrDown(levels_.back(), coarser, cv::Size(), cv::BORDER_REPLICATE);
    levels_.push_back(coarser);
  }
  return levels_[number];
}

// Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989: the unit square to a quadrilateral.
SquareToQuad::SquareToQuad(const Quad& q) {
  const Eigen::Vector2d d1 = q[1] - q[2], d2 = q[3] - q[2], s = q[0] - q[1] + q[2] - q[3];
  const double det = d1.x() * d2.y() - d1.y() * d2.x();
  const double g = (s.x() * d2.y() - s.y() * d2.x()) / det, h = (d1.x() * s.y() - d1.y() * s.x()) / det;
  Eigen::Matrix3d unit, centred;
  unit.col(0) << q[1] - q[0] + g * q[1], g;
  unit.col(1) << q[3] - q[0] + h * q[3], h;
  unit.col(2) << q[0], 1.0;
  centred << 0.5, 0.0, 0.5, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0;
  H_ = unit * centred;
}

namespace {

/// Bilinear; false outside of the image.
bool greyAt(const cv::Mat& image, const Eigen::Vector3f& p, float& grey) {
  const float last_u = static_cast<float>(image.cols) - 1.0f, last_v = static_cast<float>(image.rows) - 1.0f;
  if (!(p.z() > kNearestPlane)) return false;
  const float scale = 1.0f / p.z();
  float u = p.x() * scale, v = p.y() * scale;
  if (!(u >= -0.5f && v >= -0.5f && u <= last_u + 0.5f && v <= last_v + 0.5f)) return false;
  u = std::clamp(u, 0.0f, last_u);
  v = std::clamp(v, 0.0f, last_v);
  const int x = std::min(static_cast<int>(u), image.cols - 2), y = std::min(static_cast<int>(v), image.rows - 2);
  const float s = u - static_cast<float>(x), t = v - static_cast<float>(y);
  const uchar* top = image.data + image.step[0] * static_cast<std::size_t>(y) + x;
  const uchar* below = top + image.step[0];
  const float a = top[0] + s * (top[1] - top[0]), b = below[0] + s * (below[1] - below[0]);
  grey = a + t * (b - a);
  return true;
}

// Enough for 15 cells a side (four points to a sample): larger families take the slower way, point by point.
constexpr int kMostInRow = 64;
constexpr int kWhole = 8;  // rows are filled up to a multiple of it

/// Points of a row of the grid in the image: number of the upper left pixel, and how far beyond it.
struct RowPlaces {
  alignas(64) float s[kMostInRow], t[kMostInRow];
  alignas(64) int pixel[kMostInRow];
};

/// At H0 * x + across, for n points; false when one of them may be out of the image, or among its last few pixels,
/// where a word (below) would reach beyond it.
SEATER_VECTOR_CLONES bool place(const float* x, int n, const float* H0, const float* across, int width, int height,
                                int step, RowPlaces& __restrict places) {
  const float last_u = static_cast<float>(width) - 1.0f, last_v = static_cast<float>(height) - 1.0f;
  const float a0 = H0[0], a1 = H0[1], a2 = H0[2], b0 = across[0], b1 = across[1], b2 = across[2];
  int outside = 0;
  for (int i = 0; i < n; ++i) {
    const float z = a2 * x[i] + b2, inverse = 1.0f / z;
    const float u = (a0 * x[i] + b0) * inverse, v = (a1 * x[i] + b1) * inverse;
    const int word = static_cast<int>(u < last_u - 2.0f) | static_cast<int>(v < last_v - 1.0f);
    const int in = static_cast<int>(z > kNearestPlane) & static_cast<int>(u >= 0.0f) & static_cast<int>(v >= 0.0f) &
                   static_cast<int>(u < last_u) & static_cast<int>(v < last_v) & word;
    outside |= 1 - in;
    const float safe_u = in ? u : 0.0f, safe_v = in ? v : 0.0f;
    const int column = static_cast<int>(safe_u), row = static_cast<int>(safe_v);
    places.s[i] = safe_u - static_cast<float>(column);
    places.t[i] = safe_v - static_cast<float>(row);
    places.pixel[i] = row * step + column;
  }
  return outside == 0;
}

/// Four pixels beside each other, of which two are looked at: one load instead of two.
struct [[gnu::packed, gnu::may_alias]] Word {
  std::uint32_t pixels;
};

/// Bilinear, n points.
SEATER_VECTOR_CLONES void greyAt(const uchar* image, std::ptrdiff_t step, const RowPlaces& places, int n,
                                 float* __restrict grey) {
  const uchar* lower = image + step;
  for (int i = 0; i < n; ++i) {
    const std::uint32_t top = reinterpret_cast<const Word*>(image + places.pixel[i])->pixels;
    const std::uint32_t below = reinterpret_cast<const Word*>(lower + places.pixel[i])->pixels;
    const auto first = [](std::uint32_t word) { return static_cast<float>(static_cast<int>(word & 255U)); };
    const auto second = [](std::uint32_t word) { return static_cast<float>(static_cast<int>((word >> 8U) & 255U)); };
    const float a = first(top) + places.s[i] * (second(top) - first(top));
    const float b = first(below) + places.s[i] * (second(below) - first(below));
    grey[i] = a + places.t[i] * (b - a);
  }
}

/// Samples under H, one point at each of the grid's or four round it (`apart` > 0).
class Sampler {
 public:
  Sampler(const cv::Mat& image, const Eigen::Matrix3f& H, const PatternGrid& grid, float apart)
      : image_(image), H_(H), grid_(grid), apart_(apart), several_(apart > 0.0f), length_(grid.along()) {
    if (several_) length_ *= 2;
    whole_ = (length_ + kWhole - 1) / kWhole * kWhole;
    for (int i = 0; i < std::min(whole_, kMostInRow); ++i) {
      const int at = std::min(i, length_ - 1);
      x_[i] = several_ ? grid.x(at / 2) + (at % 2 ? apart : -apart) : grid.x(at);
    }
  }

  /// A row that lies within the image as a whole; else false.
  bool whole(int row, float* grey) const {
    if (length_ > kMostInRow) return false;
    const auto step = static_cast<std::ptrdiff_t>(image_.step[0]);
    alignas(64) float lines[2][kMostInRow];
    for (int line = 0; line < (several_ ? 2 : 1); ++line) {
      const float y = grid_.y(row) + (several_ ? (line == 0 ? -apart_ : apart_) : 0.0f);
      const Eigen::Vector3f across = H_.col(1) * y + H_.col(2);
      RowPlaces places;
      if (!place(x_, whole_, H_.data(), across.data(), image_.cols, image_.rows, static_cast<int>(step), places))
        return false;
      greyAt(image_.data, step, places, whole_, lines[line]);
    }
    for (int k = 0; k < grid_.along(); ++k) {
      const int i = 2 * k;
      grey[k] =
          several_ ? 0.25f * (lines[0][i] + lines[0][i + 1]) + 0.25f * (lines[1][i] + lines[1][i + 1]) : lines[0][k];
    }
    return true;
  }

  /// One point, which may be out of the image.
  bool single(int row, int column, float& grey) const {
    const Eigen::Vector3f p = H_.col(0) * grid_.x(column) + H_.col(1) * grid_.y(row) + H_.col(2);
    if (!several_) return greyAt(image_, p, grey);
    const Eigen::Vector3f right = apart_ * H_.col(0), down = apart_ * H_.col(1);
    float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
    if (!greyAt(image_, p + right + down, a) || !greyAt(image_, p + right - down, b) ||
        !greyAt(image_, p - right + down, c) || !greyAt(image_, p - right - down, d))
      return false;
    grey = 0.25f * (a + b + c + d);
    return true;
  }

 private:
  const cv::Mat& image_;
  const Eigen::Matrix3f& H_;
  const PatternGrid& grid_;
  const float apart_;
  const bool several_;
  int length_, whole_ = 0;  // points in a line; filled up
  float x_[kMostInRow];
};

}  // namespace

void ImageLevels::sample(const Quad& quad, const PatternGrid& grid, Samples& samples) const {
  const double cell = meanSide(quad) / grid.cells();
  std::size_t number = 0;
  while (number + 1 < most_ && cell >= 2.0 * kSeveralFrom * (1 << number)) ++number;
  const double scale = 1.0 / (1 << number);
  // Pixel i of a level lies over pixel 2 i of the finer one.
  const Eigen::Matrix3f H =
      (Eigen::Vector3d(scale, scale, 1.0).asDiagonal() * SquareToQuad(quad).matrix()).cast<float>();
  const Sampler sampler(level(number), H, grid,
                        cell >= kSeveralFrom ? kApart * 2.0f / static_cast<float>(grid.cells()) : 0.0f);
  samples.grey.setZero(grid.size());
  samples.weights.setZero(grid.size());
  samples.seen = 0;
  for (int row = 0; row < grid.along(); ++row) {
    const int first = row * grid.along();
    if (sampler.whole(row, samples.grey.data() + first)) {
      samples.weights.segment(first, grid.along()).setOnes();
      samples.seen += grid.along();
      continue;
    }
    for (int column = 0; column < grid.along(); ++column) {
      float grey = 0.0f;
      const bool seen = sampler.single(row, column, grey);
      samples.grey[first + column] = seen ? grey : 0.0f;
      samples.weights[first + column] = seen ? 1.0f : 0.0f;
      samples.seen += seen ? 1 : 0;
    }
  }
}

cv::Rect regionRound(const Quad& quad) {
  const Eigen::Vector2d low = boundingBox(quad).min(), high = boundingBox(quad).max();
  const double margin = kMargin * meanSide(quad);
  return {cv::Point(cv::saturate_cast<int>(low.x() - margin), cv::saturate_cast<int>(low.y() - margin)),
          cv::Point(cv::saturate_cast<int>(high.x() + margin), cv::saturate_cast<int>(high.y() + margin))};
}

}  // namespace seater_perception
