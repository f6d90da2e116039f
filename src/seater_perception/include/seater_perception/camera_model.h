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
  std::vector<double> D;         ///< of the raw image, as Lens has them
  std::string distortion_model;  ///< Lens lists them
  std::array<double, 12> P{};    ///< of the rectified image, row-major 3x4 [px]

  bool operator==(const Calibration& other) const;
  bool operator!=(const Calibration& other) const { return !(*this == other); }
};

/// Lens distortion, from rays (x/z, y/z) to distorted coordinates and back. Formulas: OpenCV's calib3d documentation,
/// "Camera Calibration and 3D Reconstruction" and "Fisheye camera model", which camera_model_test compares with. OpenCV
/// itself would take microseconds for a single point, of which the fits ask for thousands.
///
/// | model               | coefficients                                                                           |
/// |---------------------|----------------------------------------------------------------------------------------|
/// | plumb_bob           | k1 k2 p1 p2 [k3]                                                                       |
/// | rational_polynomial | k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tau_x tau_y]]]]: numerator and denominator of  |
/// |                     | the radial part, thin prism, tilted sensor                                             |
/// | equidistant         | k1 k2 k3 k4, of the angle from the optical axis; all 0: that angle times f is the radius |
///
/// No distortion: the first two, no name or one of librealsense's (Brown Conrady, Inverse Brown Conrady,
/// distortion.inverse_brown_conrady ...), without coefficients or with all of them 0. librealsense's with others are
/// refused: its formulas are not OpenCV's.
class Lens {
 public:
  Lens() = default;  ///< no distortion
  /// Throws CalibrationError: a coefficient is not finite, the model is unknown (the text lists those that are known),
  /// or it has another number of coefficients.
  Lens(const std::string& model, const std::vector<double>& D);

  Eigen::Vector2d distort(const Eigen::Vector2d& ray) const;
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& ray) const;  ///< of distort, by the ray
  /// The ray of distorted coordinates; nothing where there is none: beyond the radius where the model folds back, and
  /// from 86 degrees off the optical axis.
  std::optional<Eigen::Vector2d> invert(const Eigen::Vector2d& distorted) const;

 private:
  Eigen::Vector2d brown(const Eigen::Vector2d& ray) const;
  Eigen::Matrix2d brownJacobian(const Eigen::Vector2d& ray) const;
  Eigen::Vector2d fisheye(const Eigen::Vector2d& ray) const;
  Eigen::Matrix2d fisheyeJacobian(const Eigen::Vector2d& ray) const;
  std::optional<Eigen::Vector2d> invertFisheye(const Eigen::Vector2d& distorted) const;

  enum class Kind { brown, tilted, fisheye };
  Kind kind_ = Kind::brown;
  std::array<double, 12> d_{};                          // k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4; fisheye: k1 k2 k3 k4
  Eigen::Matrix3d tilt_ = Eigen::Matrix3d::Identity();  // from the sensor's plane to the tilted sensor, homogeneous
};

/// The name for a number of coefficients as OpenCV's own files have them, which name no model: 4, 5: plumb_bob;
/// otherwise rational_polynomial. `fisheye`: equidistant.
std::string opencvModel(std::size_t coefficients, bool fisheye);

/// Pinhole camera with lens distortion. Optical frame: z forward, x right, y down. A pixel's centre has integer
/// coordinates.
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
  CameraModel(int width, int height, double fx, double fy, double cx, double cy, const Lens& lens);

  int width_, height_;
  double fx_, fy_, cx_, cy_;
  Lens lens_;
};

/// Reads a file of camera_calibration (see config/cameras/d455.yaml) or of OpenCV (FileStorage, as its sample
/// `calibration` writes it). Without projection_matrix, P is all zeros: enough for raw images. Throws
/// ConfigurationError naming file and key.
Calibration loadCalibration(const std::string& path);

}  // namespace seater_perception
