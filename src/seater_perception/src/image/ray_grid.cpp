#include "image/ray_grid.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// Chosen by hand; camera_effects_test draws distorted images, in which an error of the rays would be seen.
constexpr int kNodeStep = 8;         // [px] between the nodes
constexpr double kStraight = 1e-10;  // rays less than 1e-7 px from straight ones: no distortion

}  // namespace

bool RayGrid::make(const CameraModel& camera, int u0, int v0, int u1, int v1) {
  u0_ = u0;
  v0_ = v0;
  columns_ = 2 * ((u1 - u0) / (2 * kNodeStep) + 1) + 1;
  rows_ = 2 * ((v1 - v0) / (2 * kNodeStep) + 1) + 1;
  fx_ = camera.fx(), fy_ = camera.fy(), cx_ = camera.cx(), cy_ = camera.cy();
  nodes_.clear();
  double deviation = 0.0;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const Eigen::Vector2d pixel(u0 + column * kNodeStep, v0 + row * kNodeStep);
      auto ray = camera.undistort(pixel);
      // Nodes beyond the box may lie where no ray comes from: straight on from those before.
      const auto at = nodes_.size(), row_length = static_cast<std::size_t>(columns_);
      if (!ray && pixel.x() > u1 && column > 1) ray = 2.0 * nodes_[at - 1] - nodes_[at - 2];
      if (!ray && pixel.y() > v1 && row > 1) ray = 2.0 * nodes_[at - row_length] - nodes_[at - 2 * row_length];
      if (!ray) return false;
      const Eigen::Vector2d straight((pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_);
      deviation = std::max(deviation, (*ray - straight).cwiseAbs().maxCoeff());
      nodes_.push_back(*ray);
    }
  }
  linear_ = deviation < kStraight;
  return true;
}

PixelRay RayGrid::at(double u, double v) const {
  if (linear_) return {(u - cx_) / fx_, (v - cy_) / fy_, 1.0 / fx_, 0.0, 0.0, 1.0 / fy_};
  const double x = (u - u0_) / kNodeStep, y = (v - v0_) / kNodeStep;
  const int column = std::clamp(2 * static_cast<int>(x / 2.0), 0, columns_ - 3);
  const int row = std::clamp(2 * static_cast<int>(y / 2.0), 0, rows_ - 3);
  const double s = x - column, t = y - row;
  const double ls[] = {0.5 * (s - 1.0) * (s - 2.0), s * (2.0 - s), 0.5 * s * (s - 1.0)};
  const double lt[] = {0.5 * (t - 1.0) * (t - 2.0), t * (2.0 - t), 0.5 * t * (t - 1.0)};
  const double ds[] = {s - 1.5, 2.0 - 2.0 * s, s - 0.5}, dt[] = {t - 1.5, 2.0 - 2.0 * t, t - 0.5};
  PixelRay ray;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d* node = nodes_.data() + (row + i) * columns_ + column;
    const Eigen::Vector2d along = ls[0] * node[0] + ls[1] * node[1] + ls[2] * node[2];
    const Eigen::Vector2d slope = ds[0] * node[0] + ds[1] * node[1] + ds[2] * node[2];
    ray.x += lt[i] * along.x();
    ray.y += lt[i] * along.y();
    ray.x_by_u += lt[i] * slope.x() / kNodeStep;
    ray.y_by_u += lt[i] * slope.y() / kNodeStep;
    ray.x_by_v += dt[i] * along.x() / kNodeStep;
    ray.y_by_v += dt[i] * along.y() / kNodeStep;
  }
  return ray;
}

}  // namespace seater_perception
