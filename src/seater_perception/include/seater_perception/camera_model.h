#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace seater_perception {

/// A calibration as sensor_msgs/CameraInfo and camera_calibration's files hold it; nothing is checked here.
struct Calibration {
  int width = 0;                 ///< [px]
  int height = 0;                ///< [px]
  std::array<double, 9> K{};     ///< of the raw image, row-major 3x3 [px]
  std::vector<double> D;         ///< of the raw image; plumb_bob: k1 k2 p1 p2 k3, rational_polynomial: and k4 k5 k6
  std::string distortion_model;  ///< "plumb_bob" or "rational_polynomial"
  std::array<double, 12> P{};    ///< of the rectified image, row-major 3x4 [px]

  bool operator==(const Calibration& other) const;
  bool operator!=(const Calibration& other) const { return !(*this == other); }
};

/// Pinhole camera with lens distortion. Optical frame: z forward, x right, y down. A pixel's centre has integer
/// coordinates. Formulas: OpenCV's camera model (calib3d documentation), plumb_bob and rational_polynomial.
class CameraModel {
 public:
  /// The camera of the raw image: K and D. Throws CalibrationError.
  static CameraModel raw(const Calibration& calibration);
  /// The camera of the rectified image: the left 3x3 part of P, no distortion. Throws CalibrationError.
  static CameraModel rectified(const Calibration& calibration);

  /// Pixel of a point in the optical frame [m]; nothing when it is not in front of the camera.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;
  /// Derivative of the pixel by the point [px/m], 2x3. The point has to be in front of the camera (z > 0).
  Eigen::Matrix<double, 2, 3> projectionJacobian(const Eigen::Vector3d& point) const;
  /// Undistorted coordinates (x/z, y/z) of a pixel; nothing where the distortion cannot be inverted.
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& pixel) const;

  int width() const { return width_; }
  int height() const { return height_; }
  double fx() const { return fx_; }
  double fy() const { return fy_; }
  double cx() const { return cx_; }
  double cy() const { return cy_; }

 private:
  CameraModel(int width, int height, double fx, double fy, double cx, double cy, const std::vector<double>& distortion);
  Eigen::Vector2d distort(const Eigen::Vector2d& xy) const;
  Eigen::Matrix2d distortionJacobian(const Eigen::Vector2d& xy) const;

  int width_, height_;
  double fx_, fy_, cx_, cy_;
  std::array<double, 8> d_{};  // k1 k2 p1 p2 k3 k4 k5 k6
};

/// Reads a file of camera_calibration (see config/cameras/d455.yaml). Throws ConfigurationError naming file and key.
Calibration loadCalibration(const std::string& path);

}  // namespace seater_perception
