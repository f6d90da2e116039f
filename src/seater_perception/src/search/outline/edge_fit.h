#pragma once

#include <optional>

#include "numerics/quad.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// Corners of a dark quadrilateral on light ground, from the grey levels along its four sides.
///
/// Along each side a blurred step, m + d erf((s - s0(t)) / (sqrt(2) w)), is fitted by least squares to all pixels of a
/// band (s across, t along; s0 a straight line, or a parabola for long sides, which lens distortion bends); the ends of
/// the side, where blur rounds the corner off, are left out. The corners are where neighbouring sides meet. Blur that
/// is symmetric does not move the edges, while it pulls corner detectors inwards by 0.1 to 0.3 px.
///
/// `corners` [px] to begin with, in order round the outline, within `half_band` [px] of the truth; `half_band` has to
/// be smaller than the width of the dark border. Nothing when a side does not look like one edge (covered, out of the
/// image, too short) or a corner would move by more than 1.5 `half_band`. When one moves far, all is done again from
/// there. `grey` is CV_8UC1.
struct FittedEdges {
  Quad corners;
  double psf_sd = 0.0;    ///< standard deviation of the lens' PSF, the pixel's own area not included [px]
  double residual = 0.0;  ///< rms of all four bands' pixels about their steps [grey levels]
};
std::optional<FittedEdges> fitEdges(const cv::Mat& grey, const Quad& corners, double half_band);

}  // namespace seater_perception
