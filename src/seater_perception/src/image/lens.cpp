
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "seater_perception/camera_model.h"

namespace seater_perception {
namespace {

constexpr int kNewtonSteps = 50;            // ends what does not converge
constexpr double kNewtonTolerance = 1e-12;  // in undistorted coordinates; 1e-9 px
// Beyond the radius where the distortion folds back, two rays share a pixel: there is no answer.
constexpr double kFold = 1e-3;        // determinant, or slope, of the distortion
constexpr double kWidestAngle = 1.5;  // [rad] from the optical axis: a ray is x/z, which has no end at 90 degrees
constexpr double kOnAxis = 1e-8;      // radius below which the fisheye model is its own tangent

struct Polynomial {
  double value, slope;
};

/// Radius in the image of an angle from the optical axis, over f.
Polynomial radiusOf(double angle, const std::array<double, 12>& k) {
  const double a2 = angle * angle;
  return {angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))),
          1.0 + a2 * (3.0 * k[0] + a2 * (5.0 * k[1] + a2 * (7.0 * k[2] + a2 * 9.0 * k[3])))};
}

}  // namespace

Eigen::Vector2d Lens::distort(const Eigen::Vector2d& ray) const {
  if (kind_ == Kind::fisheye) return fisheye(ray);
  const Eigen::Vector2d xy = brown(ray);
  return kind_ == Kind::tilted ? (tilt_ * xy.homogeneous()).hnormalized().eval() : xy;
}

Eigen::Matrix2d Lens::jacobian(const Eigen::Vector2d& ray) const {
  if (kind_ == Kind::fisheye) return fisheyeJacobian(ray);
  const Eigen::Matrix2d J = brownJacobian(ray);
  if (kind_ != Kind::tilted) return J;
  const Eigen::Vector3d p = tilt_ * brown(ray).homogeneous();
  return (tilt_.topLeftCorner<2, 2>() - p.hnormalized() * tilt_.bottomLeftCorner<1, 2>()) / p.z() * J;
}

Eigen::Vector2d Lens::brown(const Eigen::Vector2d& ray) const {
  const double x = ray.x(), y = ray.y();
  const double r2 = ray.squaredNorm();
  const double radial =
      (1.0 + r2 * (d_[0] + r2 * (d_[1] + r2 * d_[4]))) / (1.0 + r2 * (d_[5] + r2 * (d_[6] + r2 * d_[7])));
  return {x * radial + 2.0 * d_[2] * x * y + d_[3] * (r2 + 2.0 * x * x) + r2 * (d_[8] + r2 * d_[9]),
          y * radial + d_[2] * (r2 + 2.0 * y * y) + 2.0 * d_[3] * x * y + r2 * (d_[10] + r2 * d_[11])};
}

Eigen::Matrix2d Lens::brownJacobian(const Eigen::Vector2d& ray) const {
  const double x = ray.x(), y = ray.y();
  const double r2 = ray.squaredNorm();
  const double a = 1.0 + r2 * (d_[0] + r2 * (d_[1] + r2 * d_[4]));
  const double b = 1.0 + r2 * (d_[5] + r2 * (d_[6] + r2 * d_[7]));
  const double da = d_[0] + r2 * (2.0 * d_[1] + r2 * 3.0 * d_[4]);  // by r2
  const double db = d_[5] + r2 * (2.0 * d_[6] + r2 * 3.0 * d_[7]);
  const double radial = a / b;
  const double dradial = (da * b - a * db) / (b * b);
  Eigen::Matrix2d J = radial * Eigen::Matrix2d::Identity() + 2.0 * dradial * ray * ray.transpose();
  const double p1 = d_[2], p2 = d_[3];
  J(0, 0) += 2.0 * p1 * y + 6.0 * p2 * x;
  J(0, 1) += 2.0 * p1 * x + 2.0 * p2 * y;
  J(1, 0) += 2.0 * p1 * x + 2.0 * p2 * y;
  J(1, 1) += 6.0 * p1 * y + 2.0 * p2 * x;
  J.row(0) += 2.0 * (d_[8] + 2.0 * r2 * d_[9]) * ray.transpose();
  J.row(1) += 2.0 * (d_[10] + 2.0 * r2 * d_[11]) * ray.transpose();
  return J;
}

Eigen::Vector2d Lens::fisheye(const Eigen::Vector2d& ray) const {
  const double r = ray.norm();
  return r < kOnAxis ? ray : (radiusOf(std::atan(r), d_).value / r * ray).eval();
}

Eigen::Matrix2d Lens::fisheyeJacobian(const Eigen::Vector2d& ray) const {
  const double r = ray.norm();
  if (r < kOnAxis) return Eigen::Matrix2d::Identity();
  const Polynomial radius = radiusOf(std::atan(r), d_);
  const Eigen::Vector2d outwards = ray / r;
  const double across = radius.value / r, along = radius.slope / (1.0 + r * r);
  return across * Eigen::Matrix2d::Identity() + (along - across) * outwards * outwards.transpose();
}

std::optional<Eigen::Vector2d> Lens::invertFisheye(const Eigen::Vector2d& distorted) const {
  const double target = distorted.norm();
  if (target < kOnAxis) return distorted;
  double angle = std::min(target, kWidestAngle);
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Polynomial radius = radiusOf(angle, d_);
    if (!(radius.slope > kFold)) return std::nullopt;
    const double step = (target - radius.value) / radius.slope;
    angle += step;
    if (std::abs(step) > kNewtonTolerance) continue;
    if (!(angle > 0.0 && angle < kWidestAngle)) return std::nullopt;
    return (std::tan(angle) / target * distorted).eval();
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> Lens::invert(const Eigen::Vector2d& distorted) const {
  if (kind_ == Kind::fisheye) return invertFisheye(distorted);
  Eigen::Vector2d ray = distorted;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Eigen::Matrix2d J = jacobian(ray);
    if (!(J.determinant() > kFold)) return std::nullopt;
    const Eigen::Vector2d step = J.inverse() * (distorted - distort(ray));
    ray += step;
    if (!ray.allFinite()) return std::nullopt;
    if (step.norm() < kNewtonTolerance) return ray;
  }
  return std::nullopt;
}

}  // namespace seater_perception
