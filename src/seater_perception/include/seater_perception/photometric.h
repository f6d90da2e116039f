#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "seater_perception/camera_model.h"
#include "seater_perception/marker_pattern.h"
#include "seater_perception/pose.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// How a pose is fitted to the grey levels.
struct PhotometricParameters {
  std::string blur = "estimated";
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
    v.number("quiet_zone", quiet_zone, "cells", 0.0, 10.0, "white margin round a marker that can be relied on");
    v.number("noise_sd", noise_sd, "grey levels", 0.0, 10000.0, "known noise, for reduced_chi_square; 0: unknown");
    v.number("saturation", saturation, "grey levels", 0.0, 65535.0, "where the sensor clips; 0: largest of the type");
    v.number("reach", reach, "standard deviations", 1.0, 4.0,
             "of the blur; pixels farther from every edge are thinned out");
    v.number("margin", margin, "px", 0.0, 10.0, "the same, additionally, for the seed's error");
    v.integer("max_pixels", max_pixels, "", 200, 1000000, "most pixels used of one marker");
    v.integer("max_iterations", max_iterations, "", 1, 1000, "most evaluations of the picture");
    v.number("tukey", tukey, "standard deviations", 3.0, 20.0, "of the noise; residuals above are outliers");
    v.number("max_shift", max_shift, "sides", 0.01, 2.0, "a fit that moves a marker farther in the picture has failed");
    v.number("min_inlier_share", min_inlier_share, "", 0.1, 1.0, "a fit with fewer inliers has failed");
    v.number("min_contrast", min_contrast, "grey levels", 0.5, 10000.0,
             "a fit with less between black and white has failed");
  }
};

/// One marker and where it sits on the object whose pose is wanted.
struct PatternPlacement {
  MarkerPattern pattern;
  double size = 0.0;  ///< side of the black square [m]
  Eigen::Isometry3d T_object_marker = Eigen::Isometry3d::Identity();
};

/// Grey level = (offset + gain * white) * (1 + slope . p), white 0 or 1, p from -1 to 1 across the marker's box in the
/// picture.
struct Brightness {
  bool used = false;                ///< false: the marker is not in the picture
  double offset = 0.0, gain = 0.0;  ///< [grey levels]
  double slope_u = 0.0, slope_v = 0.0;
};

struct PhotometricResult {
  /// False: nothing else here is to be relied on; pose is then the seed, covariance zero.
  bool converged = false;
  std::string failure;                                     ///< why not converged; empty otherwise
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  /// As poseCovariance in pose.h, marginalised over brightness and blur; from the residuals' own noise.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<Brightness> brightness;  ///< one per placement
  double blur_sd = 0.0;                ///< [px] lens blur; geometric mean of both directions
  double blur_elongation = 1.0;        ///< wide over narrow direction of the whole point-spread function
  double noise_sd = 0.0;               ///< of the inliers' residuals [grey levels]
  double rms = 0.0;                    ///< of all residuals, outliers too [grey levels]
  double reduced_chi_square = 0.0;  ///< robust cost over its expectation at the known noise_sd (1 when that is unknown)
  double cost = 0.0;                ///< sum of Tukey's rho of all pixels at the result's noise_sd
  double inlier_share = 0.0;
  int pixels = 0, iterations = 0;
};

/// Fits the pose of printed markers to the grey levels of a picture: every pixel near a cell border is compared with
/// the pattern smoothed by pixel area and lens blur, and the weighted squares of the differences are minimised over
/// pose, brightness and, if wanted, blur (Levenberg-Marquardt, first with Huber's, then with Tukey's weights: Huber,
/// "Robust Statistics", 1981).
///
/// Clipped pixels (0, saturation) are compared with the mean of a clipped noisy pixel, so that they neither pull nor
/// get lost.
class PhotometricRefiner {
 public:
  /// Throws ConfigurationError for an unknown `blur`.
  explicit PhotometricRefiner(const PhotometricParameters& parameters);

  /// `grey` is CV_8UC1 or CV_16UC1 of the camera's size, else PictureError is thrown. `initial` is T_optical_object,
  /// good to a pixel or a third of a cell, whichever is larger. Whatever is in the picture, the result is finite.
  PhotometricResult refine(const cv::Mat& grey, const CameraModel& camera,
                           const std::vector<PatternPlacement>& placements, const Eigen::Isometry3d& initial) const;

  const PhotometricParameters& parameters() const { return parameters_; }

 private:
  PhotometricParameters parameters_;
};

/// Refines every seed and weighs the distinct results by their residuals alone: w ~ exp(-chi^2 / 2), all on the same
/// pixels, with the best one's noise. Results that did not converge get weight 0. Sum 1 unless none converged.
struct PhotometricBranch {
  PhotometricResult result;
  double chi_square = 0.0;  ///< robust, on the pixels common to all branches
  double weight = 0.0;
};
std::vector<PhotometricBranch> refineBranches(const PhotometricRefiner& refiner, const cv::Mat& grey,
                                              const CameraModel& camera,
                                              const std::vector<PatternPlacement>& placements,
                                              const std::vector<Eigen::Isometry3d>& seeds);

}  // namespace seater_perception
