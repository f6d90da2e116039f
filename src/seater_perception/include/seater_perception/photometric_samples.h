#pragma once

#include <optional>
#include <vector>

#include "seater_perception/photometric.h"
#include "seater_perception/photometric_model.h"

namespace seater_perception {

/// A pixel that the fit looks at.
struct PixelSample {
  double grey = 0.0;
  double pu = 0.0, pv = 0.0;  ///< place within the marker's box, -1 to 1
  bool edge = false;          ///< a cell border is near
  double step = 0.0;          ///< difference to the next pixel of the row, of flat pixels [grey levels]
};

/// The pixels of one marker, collected once; `rays_per_pixel` rays for each of them, in the same order.
struct MarkerSamples {
  std::vector<PixelSample> pixels;
  std::vector<PixelRay> rays;
  int rays_per_pixel = 1;
  int edges = 0;      ///< how many of the pixels are edge pixels
  double side = 0.0;  ///< of the marker in the picture [px]
  bool empty() const { return pixels.empty(); }
};

/// Variance [px^2] that the pixel's area adds to the blur when a pixel is looked at along this many rays.
double areaVariance(int rays_per_pixel);
/// Rays per pixel needed at this blur: one where the pixel's box is as good as a Gaussian, four where it is not.
int raysPerPixel(double blur_sd);

/// Rays of all pixels of a box, distortion inverted exactly on a grid and interpolated between (1e-4 px).
class RayGrid {
 public:
  /// Nothing when a part of the box cannot be undistorted.
  static std::optional<RayGrid> make(const CameraModel& camera, int u0, int v0, int u1, int v1);
  PixelRay at(double u, double v) const;

 private:
  int u0_ = 0, v0_ = 0, columns_ = 0, rows_ = 0;
  bool linear_ = false;
  double fx_ = 1.0, fy_ = 1.0, cx_ = 0.0, cy_ = 0.0;
  std::vector<Eigen::Vector2d> nodes_;
};

/// Pixels of a marker whose pose in the optical frame may be any of these (one or more): near an edge of at least one
/// of them, inside the sheet for all. `margin` [px] is how far the poses may be off; `sparse`: only as many as a first
/// fit needs. Empty when it is not in the picture.
MarkerSamples collectSamples(const cv::Mat& grey, const CameraModel& camera, const PatternPlacement& placement,
                             const std::vector<Eigen::Isometry3d>& T_optical_marker, double blur_sd, double margin,
                             bool sparse, const PhotometricParameters& parameters);

}  // namespace seater_perception
