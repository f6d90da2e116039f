#include "pose/shift_field.h"

#include <algorithm>
#include <cmath>

#include "numerics/symmetric.h"

namespace seater_perception {
namespace {

// Chosen by the normalised errors of drawn kinds of cameras and shifts (docs/results/photographs.md).
constexpr double kMargin = 0.75;     // [standard deviations of the variance] an estimate that is too small is dangerous
constexpr double kPriorModes = 1.0;  // the usual shift counts as if so many modes had shown it
constexpr int kRounds = 3;
constexpr double kSmallestVariance = 1e-4, kFirstVariance = 0.01;  // [px^2]

constexpr double kPlaces = 0.42;  // [sides] how far from the middle the outer places are

}  // namespace

double shiftCorrelation(const Eigen::Vector2d& apart, double smoothness) {
  return std::exp(-apart.squaredNorm() / (4.0 * smoothness * smoothness));
}

void ShiftField::add(double information, double square, double weight) {
  if (information > 0.0) modes_.push_back({information, square, weight});
}

double ShiftField::variance(double usual) const {
  const double prior = usual * usual;
  double v = prior > 0.0 ? prior : kFirstVariance, sigma = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    // Weights that are right for this variance. What the prior counts never exceeds what modes tell at its own.
    const double at = std::max(v, kSmallestVariance), prior_at = std::max(at, prior);
    double seen = 0.0, expected = 0.0;
    for (const Mode& m : modes_) {
      const double damped = 1.0 + at * m.information, w = m.weight / (damped * damped);
      seen += w * (m.square - m.information);
      expected += w * m.information * m.information;
    }
    const double counts = prior > 0.0 ? kPriorModes / (prior_at * prior_at) : 0.0;
    if (!(expected + counts > 0.0)) return prior;
    v = (std::max(0.0, seen) + counts * prior) / (expected + counts);
    sigma = std::sqrt(2.0 / (expected + counts));
  }
  return v + kMargin * sigma;
}

void ShiftedPlaces::add(double size, const Eigen::Isometry3d& T_object_marker, double shift_sigma) {
  for (const double x : {-kPlaces, 0.0, kPlaces}) {
    for (const double y : {-kPlaces, 0.0, kPlaces}) {
      object.push_back(T_object_marker * Eigen::Vector3d(x * size, y * size, 0.0));
      sigma.push_back(shift_sigma);
    }
  }
}

std::optional<Matrix6d> shiftCovariance(const CameraModel& camera, const ShiftedPlaces& places,
                                        const Eigen::Isometry3d& pose) {
  const std::size_t count = places.object.size();
  std::vector<Eigen::Vector2d> pixels(count);
  std::vector<Eigen::Matrix<double, 2, 6>> J(count);
  Matrix6d information = Matrix6d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d arm = pose.linear() * places.object[i], point = arm + pose.translation();
    const auto pixel = camera.project(point);
    if (!pixel) return std::nullopt;
    pixels[i] = *pixel;
    J[i] = pixelByPose(camera, arm, point);
    information += J[i].transpose() * J[i];
  }
  Matrix6d noise = Matrix6d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    noise += places.sigma[i] * places.sigma[i] * J[i].transpose() * J[i];
    for (std::size_t k = 0; k < i; ++k) {
      const double alike = shiftCorrelation(pixels[i] - pixels[k], kUsualSmoothness);
      const Matrix6d both = places.sigma[i] * places.sigma[k] * alike * J[i].transpose() * J[k];
      noise += both + both.transpose();
    }
  }
  // Metres and radians differ by orders of magnitude.
  const Vector6d scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const auto scaled = solvedPositive(scale.asDiagonal() * information * scale.asDiagonal(), Matrix6d::Identity());
  if (!scaled) return std::nullopt;
  const Matrix6d inverse = scale.asDiagonal() * Matrix6d(*scaled) * scale.asDiagonal();
  const Matrix6d covariance = inverse * noise * inverse.transpose();
  if (!covariance.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (covariance + covariance.transpose()));
}

}  // namespace seater_perception
