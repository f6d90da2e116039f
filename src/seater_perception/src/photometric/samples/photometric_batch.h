#pragma once

#include <vector>

namespace seater_perception {

/// Pixels near cell borders, as arrays that vector code reads. Index i of every array belongs to one pixel; the pixels
/// are in an order of which every beginning is spread evenly over the marker. Arrays are padded to whole kLanes.
struct PixelBatch {
  static constexpr int kLanes = 16;
  static constexpr int kMostBorders = 6;  ///< felt along one axis; more only if the PSF is wider than a cell

  int count = 0;                    ///< pixels
  int padded = 0;                   ///< length of the arrays
  int borders = 1;                  ///< of cells, that are felt along each axis
  bool bent = false;                ///< the camera's rays bend: each pixel has its own derivative of the ray
  std::vector<float> grey, pu, pv;  ///< grey level; place within the marker's box, -1 to 1
  /// Ray x/z, y/z from the middle one, times the camera's fx and fy [px]; its derivatives by the pixel, when bent.
  std::vector<float> x, y, xu, xv, yu, yv;
  std::vector<float> column, row;  ///< first of the borders felt [cells from the marker's centre]
  /// The pattern as sum over the borders felt: white = base + sum_i S_i Px_i + sum_j (A_j + sum_i C_ij Px_i) Py_j, with
  /// P the share that lies beyond a border. (borders + 1)^2 arrays: base, S_i, A_j, C_ij (i fastest).
  std::vector<float> pattern;
  float x_min = 0.0F, x_max = 0.0F, y_min = 0.0F, y_max = 0.0F;

  int planes() const { return (borders + 1) * (borders + 1); }
  const float* plane(int k) const { return pattern.data() + static_cast<std::size_t>(k) * padded; }
  float* plane(int k) { return pattern.data() + static_cast<std::size_t>(k) * padded; }
};

/// Pixels far from all borders, summed up: they tell brightness only.
struct FlatBlock {
  double grey = 0.0;  ///< mean
  double pu = 0.0, pv = 0.0;
  double white = 0.0;  ///< 0 or 1
  double count = 0.0;
};

/// What the fit looks at of one marker.
struct MarkerSamples {
  PixelBatch batch;
  std::vector<FlatBlock> blocks;
  std::vector<float> steps;         ///< differences of neighbours within blocks [grey levels]: the noise alone
  double ray_x = 0.0, ray_y = 0.0;  ///< the middle ray
  int rays_per_pixel = 1;
  double half_sheet = 0.0;  ///< half the side of print and quiet zone, where pixels see its end [cells]; 0: none does
  bool empty() const { return batch.count == 0; }
  void clear() {
    batch.count = batch.padded = 0;
    blocks.clear();
    steps.clear();
  }
};

}  // namespace seater_perception
