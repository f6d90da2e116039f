#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "seater_perception/camera_model.h"
#include "seater_perception/detection.h"
#include "seater_perception/marker_pattern.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What a fit has left over of shifts of parts of a print that are smooth over the image (prints not flat, what is left
/// of a lens' distortion, line jitter), along directions in which they do not mix. Of a field of variance v [px^2], the
/// square along a direction of information i is expected to be i + v i^2: i of it is the noise of the grey levels.
struct ShiftEvidence {
  static constexpr int kModes = 18;

  std::array<double, kModes> information{};  ///< [1/px^2]; 0: tells nothing
  std::array<double, kModes> square{};       ///< [1/px^2]
};

/// What a fit gives.
struct PhotometricResult {
  /// False: nothing else here is to be relied on; pose is then the initial one, covariance zero.
  bool converged = false;
  std::string failure;                                     ///< why not converged; empty otherwise
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  /// As PoseHypothesis::covariance, marginalised over all else; from the residuals' own noise.
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<Brightness> brightness;  ///< one per placement
  double psf_sd = 0.0;                 ///< of the lens' point spread function; geometric mean of both directions [px]
  double psf_elongation = 1.0;         ///< wide over narrow direction of the whole point spread function
  double noise_sd = 0.0;               ///< of the inliers' residuals [grey levels]
  double flat_noise = 0.0;             ///< of pixels far from all edges; 0: none [grey levels]
  double rms = 0.0;                    ///< of all residuals, outliers too [grey levels]
  double reduced_chi_square = 0.0;  ///< robust cost over its expectation at the known noise_sd (1 when that is unknown)
  double cost = 0.0;                ///< sum of Tukey's rho of all pixels at the result's noise_sd
  double inlier_fraction = 0.0;
  double explained = 0.0;  ///< part of the grey levels' variance that the pattern explains, outliers included; 1: all
  double clipped_low = 0.0, clipped_high = 0.0;  ///< fraction of the pixels at either end of the sensor's range
  int pixels = 0, iterations = 0;
  ShiftEvidence shifts;  ///< of the best fit of one print
};

/// The result from one initial pose and what it weighs beside the others'.
struct PhotometricBranch {
  PhotometricResult result;
  double chi_square = 0.0;  ///< robust, on the pixels common to all branches
  double weight = 0.0;
  bool hopeless = false;  ///< a first look showed that it is clearly worse than another
};

/// What is known before a fit begins.
struct PhotometricStart {
  /// Standard deviation of the lens' point spread function [px]; > 0: the initial poses are exact to about 0.1 px and
  /// nothing is covered, so that the first, careful approach is left out; 0: as the parameters say, and the initial
  /// poses are as for `refine`.
  double psf_sd = 0.0;
  /// Of one marker, from other sources; then every initial pose is believed to be near a minimum, and none is given up
  /// at a first look.
  std::optional<Brightness> brightness;
  /// Nothing covers the prints: however large residuals are at edges, the camera has made them, and all count. Else
  /// those that are far above the noise are forgotten.
  bool whole = false;
};

/// Fits the pose of printed markers to the grey levels of an image: every pixel near a cell border is compared with
/// the pattern smoothed by pixel area and lens, and the weighted squares of the differences are minimised over pose,
/// brightness and, if wanted, point spread function (Levenberg-Marquardt, first with Huber's, then with Tukey's
/// weights: Huber, "Robust Statistics", 1981).
///
/// Clipped pixels (0, saturation) are compared with the mean of a clipped noisy pixel, so that they neither pull nor
/// get lost.
///
/// One per thread: calls write into memory that the next call uses again. Results do not depend on earlier calls.
class PhotometricRefiner {
 public:
  /// Throws ConfigurationError for an unknown `blur`.
  explicit PhotometricRefiner(const PhotometricParameters& parameters);
  ~PhotometricRefiner();
  PhotometricRefiner(PhotometricRefiner&&) noexcept;

  /// `grey` is CV_8UC1 or CV_16UC1 of the camera's size, else ImageError is thrown. `initial` is T_optical_object,
  /// good to a pixel or a third of a cell, whichever is larger. Whatever is in the image, the result is finite.
  PhotometricResult refine(const cv::Mat& grey, const CameraModel& camera,
                           const std::vector<PatternPlacement>& placements, const Eigen::Isometry3d& initial);

  /// Refines every initial pose, the most probable one first, and weighs the distinct results by their residuals alone:
  /// w ~ exp(-chi^2 / 2), all on the same pixels, with the best one's noise. Results that did not converge get weight
  /// 0, and so do those that a first look at a part of the pixels shows to be hopeless or the same as an earlier one.
  /// The weights add up to 1 unless none converged.
  std::vector<PhotometricBranch> refineBranches(const cv::Mat& grey, const CameraModel& camera,
                                                const std::vector<PatternPlacement>& placements,
                                                const std::vector<Eigen::Isometry3d>& initial,
                                                const PhotometricStart& start = {});

  const PhotometricParameters& parameters() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace seater_perception
