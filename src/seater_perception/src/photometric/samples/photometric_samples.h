#pragma once

#include <vector>

#include "image/ray_grid.h"
#include "photometric/samples/photometric_batch.h"
#include "seater_perception/camera_model.h"
#include "seater_perception/marker_pattern.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// Variance [px^2] that the pixel's area adds to the PSF when a pixel is looked at along this many rays.
double areaVariance(int rays_per_pixel);
/// Rays per pixel needed at this PSF: one where the pixel's box is as good as a Gaussian, four where it is not.
int raysPerPixel(double psf_sd);

/// A box of pixels, last ones included.
struct PixelBox {
  int u0, v0, u1, v1;
};

/// A pixel near a border.
struct PixelCandidate {
  int u = 0, v = 0;
  float x = 0.0F, y = 0.0F;  ///< where it sees the marker [cells from its lower left corner]
};

/// Collects the pixels of one marker. Holds the memory for it, so that it is used again for the next one.
class SampleCollector {
 public:
  /// Pixels of a marker whose pose in the optical frame is about this one. `margin` [px] is how far the pose may be
  /// off; `most`: no more than so many; `rim`: small markers may have pixels that see the end of the sheet. Empty when
  /// it is not in the image.
  void collect(const cv::Mat& grey, const CameraModel& camera, const PatternPlacement& placement,
               const Eigen::Isometry3d& T_optical_marker, double psf_sd, double margin, int most, bool rim,
               const PhotometricParameters& parameters, MarkerSamples& samples);

 private:
  void fill(const cv::Mat& grey, const CameraModel& camera, const MarkerPattern& pattern, const PixelBox& box, int most,
            MarkerSamples& samples);
  void tabulate(const MarkerPattern& pattern, const PixelBatch& batch);
  void fillPattern(int cells, PixelBatch& batch);
  void bendRays(const CameraModel& camera, MarkerSamples& samples);
  void setRange(const PixelBox& box, const CameraModel& camera, MarkerSamples& samples) const;
  static bool sheetBox(const CameraModel& camera, const PatternPlacement& placement, const Eigen::Isometry3d& pose,
                       double quiet_zone, PixelBox& box);

  RayGrid grid_;
  std::vector<PixelCandidate> candidates_;
  std::vector<int> order_;    // of the candidates in the batch
  std::vector<float> table_;  // PixelBatch::pattern for all places of the borders, up to
  std::vector<float> cells_;  // of which it is made
  int ring_ = 0;              // so far beyond the pattern [cells]
};

}  // namespace seater_perception
