// Which pixels of a marker's box tell something: those near cell borders, one by one; those far from all, summed up.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "photometric/samples/photometric_batch.h"
#include "photometric/samples/photometric_samples.h"

namespace seater_perception {

class PixelWalk {
 public:
  /// `rim`: pixels may see the end of the sheet. `sd`: of the point-spread function [px]; `margin` [px]: how far the
  /// pose may be off.
  PixelWalk(const cv::Mat& grey, const PatternPlacement& placement, const Eigen::Isometry3d& T_optical_marker,
            double sd, double margin, const PhotometricParameters& parameters, const RayGrid& grid, bool rim);

  /// Adds candidates, and to the samples blocks and steps of flat pixels.
  void run(const PixelBox& box, std::vector<PixelCandidate>& candidates, MarkerSamples& samples);

  /// Largest standard deviation of the point-spread function on the marker, and largest error of the pose [cells].
  double widest() const { return widest_; }
  double off() const { return off_; }

 private:
  /// The marker as seen about the middle of a tile: linear.
  struct Tile {
    double x, y, xu, xv, yu, yv;  // [cells], [cells/px]
    float wx, wy;                 // half width of the band of edge pixels [cells]
    float fx, fy;                 // the same, beyond which pixels are flat
    float qx, qy;                 // width of the quiet zone that can be relied on [cells]
    float sx, sy;                 // the same of flat pixels
  };
  enum class Kind { outside, flat, mixed };

  bool look(double u, double v, Tile& tile);
  Kind kindOf(const Tile& tile, double radius) const;
  bool uniform(float x, float y, float wx, float wy) const;
  bool white(float x, float y) const { return cells_[static_cast<std::size_t>(index(y) * side_ + index(x))] != 0; }
  /// Floor of what is above -kRing, as a place in the table.
  static int index(float x) { return static_cast<int>(x + static_cast<float>(kRing)); }
  void addStep(double a, double b, MarkerSamples& samples) const;
  template <typename Grey>
  void walk(const PixelBox& box, std::vector<PixelCandidate>& candidates, MarkerSamples& samples);
  template <typename Grey>
  void addBlock(const PixelBox& part, const Tile& tile, const PixelBox& whole, MarkerSamples& samples) const;
  template <typename Grey>
  void sort(const PixelBox& part, const Tile& tile, const PixelBox& whole, std::vector<PixelCandidate>& candidates,
            MarkerSamples& samples) const;

  static constexpr int kRing = 6;  // cells of quiet zone round the pattern in the table

  const cv::Mat& grey_;
  const MarkerPlane plane_;
  const PhotometricParameters& parameters_;
  const RayGrid& grid_;
  const double clearance_;
  const double sd_, margin_, per_metre_, count_, limit_;
  const int side_;           // of the table
  std::vector<char> cells_;  // the table: 1 white, row by row from kRing below the pattern
  double widest_ = 0.0, off_ = 0.0;
};

}  // namespace seater_perception
