// Images and Cramer-Rao bounds for the photometric tests, made in another way than the model does it: rays through a
// fine grid (samples x samples per pixel), the lens blur applied on that grid, then the mean over each pixel's area.
// Derivatives are numeric.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "scene.h"

namespace photo_scene {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using seater_perception::Vector6d;

struct View {
  seater_perception::Calibration camera = scene::calibration();
  std::vector<scene::Print> prints;  // T_optical_marker at the object's pose `pose`
  Isometry3d pose = Isometry3d::Identity();
  double blur = 0.7;  // [px]
  double black = 40.0, white = 215.0;
  Vector2d motion = Vector2d::Zero();  // [px] path of the image during the exposure
  int samples = 8;
};

/// The same scene with the object moved: t' = t + d, R' = exp([w]x) R.
View moved(const View& setup, const Vector6d& change);

/// Box of a print's sheet in the image, `margin` cells wider than the print.
cv::Rect boxOf(const View& setup, const scene::Print& print, double margin, int cells);

/// The whole image without noise (CV_64F), paper everywhere.
cv::Mat clean(const View& setup);

cv::Mat withNoise(const cv::Mat& clean, double sd, unsigned seed, int type = CV_8U);

struct Bound {
  Eigen::Matrix<double, 6, 6> covariance;  // of the pose, all else unknown
  double position() const { return std::sqrt(covariance.topLeftCorner<3, 3>().trace()); }
  double rotation() const { return std::sqrt(covariance.bottomRightCorner<3, 3>().trace()); }
};

/// Cramer-Rao bound with unknown pose, offset and gain of each print and, if asked for, point spread function and two
/// slopes of brightness.
Bound cramerRao(const View& setup, double noise, bool blur, bool slopes);

/// Error (d, w) of a pose, as pose.h defines it.
Vector6d errorOf(const Isometry3d& estimate, const Isometry3d& truth);

/// A print of `size` on the object's origin.
View single(double size, double distance, double yaw, double pitch = 0.0, double roll = 0.03);

/// An initial pose as corner detection would give it: some tenths of a pixel, a percent of the distance and degrees
/// off.
Isometry3d initialNear(const View& setup, std::mt19937& random, double pixels = 0.3, double depth = 0.01,
                       double turn = 0.03);

}  // namespace photo_scene
