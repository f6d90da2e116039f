#include "seater_perception/camera_model.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

template <typename Container>
void requireFinite(const Container& values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      std::ostringstream text;
      text << name << "[" << i << "] is " << values[i] << ", must be finite";
      throw CalibrationError(text.str());
    }
  }
}

void requireZero(double value, const char* name, const char* why) {
  if (value != 0.0) {
    std::ostringstream text;
    text << name << " is " << value << ", must be 0 (" << why << ")";
    throw CalibrationError(text.str());
  }
}

void requireLens(int width, int height, double fx, double fy, const char* fx_name, const char* fy_name) {
  std::ostringstream text;
  if (width <= 0 || height <= 0) {
    text << "image size is " << width << " x " << height << ", must be positive";
  } else if (fx <= 0.0) {
    text << fx_name << " (focal length) is " << fx << ", must be > 0; 0 means that the camera is not calibrated";
  } else if (fy <= 0.0) {
    text << fy_name << " (focal length) is " << fy << ", must be > 0";
  }
  if (!text.str().empty()) throw CalibrationError(text.str());
}

}  // namespace

bool Calibration::operator==(const Calibration& other) const {
  // A NaN never equals itself, so a broken calibration is looked at (and refused) every time.
  return width == other.width && height == other.height && K == other.K && D == other.D &&
         distortion_model == other.distortion_model && P == other.P;
}

CameraModel::CameraModel(int width, int height, double fx, double fy, double cx, double cy, const Lens& lens)
    : width_(width), height_(height), fx_(fx), fy_(fy), cx_(cx), cy_(cy), lens_(lens) {}

CameraModel CameraModel::raw(const Calibration& c) {
  requireFinite(c.K, "K");
  requireLens(c.width, c.height, c.K[0], c.K[4], "K[0]", "K[4]");
  requireZero(c.K[1], "K[1]", "skew is not supported");
  for (const auto& [i, name] : {std::pair(3, "K[3]"), std::pair(6, "K[6]"), std::pair(7, "K[7]")}) {
    requireZero(c.K[static_cast<std::size_t>(i)], name, "K is upper triangular");
  }
  if (c.K[8] != 1.0) throw CalibrationError("K[8] is " + std::to_string(c.K[8]) + ", must be 1");
  return CameraModel(c.width, c.height, c.K[0], c.K[4], c.K[2], c.K[5], Lens(c.distortion_model, c.D));
}

CameraModel CameraModel::rectified(const Calibration& c) {
  requireFinite(c.P, "P");
  requireLens(c.width, c.height, c.P[0], c.P[5], "P[0]", "P[5]");
  requireZero(c.P[1], "P[1]", "skew is not supported");
  requireZero(c.P[3], "P[3]", "the second camera of a stereo pair is not supported");
  requireZero(c.P[7], "P[7]", "the second camera of a stereo pair is not supported");
  return CameraModel(c.width, c.height, c.P[0], c.P[5], c.P[2], c.P[6], Lens());
}

std::optional<Eigen::Vector2d> CameraModel::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > 1e-9)) return std::nullopt;
  const Eigen::Vector2d xy = lens_.distort(point.head<2>() / point.z());
  const Eigen::Vector2d pixel(fx_ * xy.x() + cx_, fy_ * xy.y() + cy_);
  if (!pixel.allFinite()) return std::nullopt;
  return pixel;
}

Eigen::Matrix<double, 2, 3> CameraModel::projectionJacobian(const Eigen::Vector3d& point) const {
  const double z = point.z();
  const Eigen::Vector2d xy = point.head<2>() / z;
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1.0 / z, 0.0, -xy.x() / z, 0.0, 1.0 / z, -xy.y() / z;
  return Eigen::Vector2d(fx_, fy_).asDiagonal() * lens_.jacobian(xy) * by_point;
}

std::optional<Eigen::Vector2d> CameraModel::undistort(const Eigen::Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  return lens_.invert({(pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_});
}

}  // namespace seater_perception
