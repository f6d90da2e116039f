#pragma once

#include <string>

namespace seater_perception {

/// How a pose is fitted to the grey levels.
struct PhotometricParameters {
  std::string blur = "directed";
  double blur_sd = 0.7;
  bool illumination_slope = true;
  double quiet_zone = 1.0;
  double noise_sd = 0.0;
  double saturation = 0.0;
  double reach = 2.5;
  double margin = 0.7;
  int max_pixels = 8000;
  int max_iterations = 40;
  double tukey = 6.0;
  double max_shift = 0.3;
  double min_inlier_share = 0.5;
  double min_contrast = 4.0;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.choice("blur", blur, {"given", "estimated", "directed"},
             "the camera's blur: as given; one width estimated; a width along each direction estimated (motion)");
    v.number("blur_sd", blur_sd, "px", 0.0, 10.0, "standard deviation of lens blur, the pixel's own area not included");
    v.boolean("illumination_slope", illumination_slope, "estimate how brightness changes over the marker");
    v.number("quiet_zone", quiet_zone, "cells", 0.0, 2.0, "white margin round a marker that can be relied on");
    v.number("noise_sd", noise_sd, "grey levels", 0.0, 10000.0, "known noise, for reduced_chi_square; 0: unknown");
    v.number("saturation", saturation, "grey levels", 0.0, 65535.0, "where the sensor clips; 0: largest of the type");
    v.number("reach", reach, "standard deviations", 1.0, 4.0,
             "of the blur; pixels farther from every edge are thinned out");
    v.number("margin", margin, "px", 0.0, 10.0, "the same, additionally, for the seed's error");
    v.integer("max_pixels", max_pixels, "", 200, 1000000, "most pixels used of one marker");
    v.integer("max_iterations", max_iterations, "", 1, 1000, "most evaluations of the image");
    v.number("tukey", tukey, "standard deviations", 3.0, 20.0, "of the noise; residuals above are outliers");
    v.number("max_shift", max_shift, "sides", 0.01, 2.0, "a fit that moves a marker farther in the image has failed");
    v.number("min_inlier_share", min_inlier_share, "", 0.1, 1.0, "a fit with fewer inliers has failed");
    v.number("min_contrast", min_contrast, "grey levels", 0.5, 10000.0,
             "a fit with less between black and white has failed");
  }
};

}  // namespace seater_perception
