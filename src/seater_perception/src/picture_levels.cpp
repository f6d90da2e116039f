#include "seater_perception/picture_levels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace seater_perception {
namespace {

constexpr double kSeveralFrom = 4.0;  // [px] of a cell: four points round each of the grid, at a level with such cells
constexpr float kApart = 0.14f;       // [cells] these from that, to each side: the blur is then nearly the print's own
constexpr int kMostLevels = 8, kSmallestLevel = 24;
constexpr float kNearestPlane = 0.05f;  // of the homography's third coordinate

}  // namespace

PictureLevels::PictureLevels(const cv::Mat& grey) {
  levels_.push_back(grey);
  for (int length = std::min(grey.cols, grey.rows); most_ < kMostLevels && length >= 2 * kSmallestLevel; ++most_)
    length = (length + 1) / 2;
}

const cv::Mat& PictureLevels::level(std::size_t number) const {
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

double meanSide(const Quad& q) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += (q[(i + 1) % 4] - q[i]).norm();
  return 0.25 * sum;
}

namespace {

/// Bilinear; false outside of the picture.
bool greyAt(const cv::Mat& picture, const Eigen::Vector3f& p, float& grey) {
  const float last_u = static_cast<float>(picture.cols) - 1.0f, last_v = static_cast<float>(picture.rows) - 1.0f;
  if (!(p.z() > kNearestPlane)) return false;
  const float scale = 1.0f / p.z();
  float u = p.x() * scale, v = p.y() * scale;
  if (!(u >= -0.5f && v >= -0.5f && u <= last_u + 0.5f && v <= last_v + 0.5f)) return false;
  u = std::clamp(u, 0.0f, last_u);
  v = std::clamp(v, 0.0f, last_v);
  const int x = std::min(static_cast<int>(u), picture.cols - 2), y = std::min(static_cast<int>(v), picture.rows - 2);
  const float s = u - static_cast<float>(x), t = v - static_cast<float>(y);
  const uchar* top = picture.data + picture.step[0] * static_cast<std::size_t>(y) + x;
  const uchar* below = top + picture.step[0];
  const float a = top[0] + s * (top[1] - top[0]), b = below[0] + s * (below[1] - below[0]);
  grey = a + t * (b - a);
  return true;
}

}  // namespace

void PictureLevels::sample(const Quad& quad, const PatternGrid& grid, Samples& samples) const {
  const double cell = meanSide(quad) / grid.cells();
  const bool several = cell >= kSeveralFrom;
  std::size_t number = 0;
  while (number + 1 < most_ && cell >= 2.0 * kSeveralFrom * (1 << number)) ++number;
  const cv::Mat& picture = level(number);
  const double scale = 1.0 / (1 << number);
  // Pixel i of a level lies over pixel 2 i of the finer one.
  const Eigen::Matrix3f H =
      (Eigen::Vector3d(scale, scale, 1.0).asDiagonal() * SquareToQuad(quad).matrix()).cast<float>();
  const float apart = kApart * 2.0f / static_cast<float>(grid.cells());
  const Eigen::Vector3f right = apart * H.col(0), down = apart * H.col(1);
  samples.grey.setZero(grid.size());
  samples.weights.setZero(grid.size());
  samples.seen = 0;
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    const Eigen::Vector3f across = H.col(1) * grid.y(row) + H.col(2);
    for (int column = 0; column < grid.along(); ++column, ++i) {
      const Eigen::Vector3f p = H.col(0) * grid.x(column) + across;
      float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
      if (several) {
        if (!greyAt(picture, p + right + down, a) || !greyAt(picture, p + right - down, b) ||
            !greyAt(picture, p - right + down, c) || !greyAt(picture, p - right - down, d))
          continue;
        samples.grey[i] = 0.25f * (a + b + c + d);
      } else {
        if (!greyAt(picture, p, a)) continue;
        samples.grey[i] = a;
      }
      samples.weights[i] = 1.0f;
      ++samples.seen;
    }
  }
}

}  // namespace seater_perception
