#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "numerics/quad.h"
#include "search/code/pattern_template.h"

namespace seater_perception {

/// A CV_8UC1 image and its halvings, smoothed so that a level can be sampled anywhere (P. Burt and E. Adelson, "The
/// Laplacian pyramid as a compact image code", 1983), made when they are needed. Holds no copy of the image: it has
/// to outlive this. Not thread-safe.
class ImageLevels {
 public:
  explicit ImageLevels(const cv::Mat& grey);

  const cv::Mat& grey() const { return levels_.front(); }

  /// Grey levels under a quadrilateral (corners of the print's square: -1 -1, 1 -1, 1 1, -1 1) at the points of the
  /// grid; of cells from 4 px on, the mean of four points round each, from the level in which cells have 4 to 8 px, so
  /// that each sample stands for its part of a cell. Weight 1; outside of the image, and where the quadrilateral's
  /// plane is behind the camera, weight and sample 0.
  struct Samples {
    Eigen::VectorXf grey, weights;
    int seen = 0;
    bool all() const { return seen == static_cast<int>(grey.size()); }
  };
  void sample(const Quad& quad, const PatternGrid& grid, Samples& samples) const;

 private:
  const cv::Mat& level(std::size_t number) const;

  mutable std::vector<cv::Mat> levels_;
  std::size_t most_ = 1;
};

/// The point of the quadrilateral's plane at (x, y) of the square -1 .. 1.
class SquareToQuad {
 public:
  explicit SquareToQuad(const Quad& quad);
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const { return (H_ * p.homogeneous()).hnormalized(); }
  const Eigen::Matrix3d& matrix() const { return H_; }

 private:
  Eigen::Matrix3d H_;
};

/// A print's surroundings [px]: its quiet zone and some more on each side. May reach beyond the image.
cv::Rect regionRound(const Quad& quad);

}  // namespace seater_perception
