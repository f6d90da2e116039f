#include "pose/shift_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "numerics/symmetric.h"

namespace seater_perception {
namespace {

// Chosen by the normalised errors of drawn kinds of cameras and shifts (docs/results/beyond_simulation.md).
// The prior of shifts is a distribution, no floor: the logarithm is normal. Its median is far above what is usual, as
// shifts that are overlooked are dangerous; any that markers show outweighs it.
constexpr double kMedian = 5.0;      // [usual shifts]
constexpr double kSpread = 1.2;      // standard deviation of the logarithm
constexpr double kFirstUsual = 0.1;  // [px] where none is usual
// Probability that there are none at all, where the image is as modelled.
constexpr double kNone = 0.5;
// Of the logarithm of the factor of the noise; that is 1 where errors are independent.
constexpr double kAlikeSpread = 0.7;
// Photographs show mostly shifts that are alike over 8 to 20 px; boards that are bent, and lenses, smoother ones.
constexpr std::array<double, ShiftGrid::kSmoothness.size()> kSmoothnessPrior{1.0, 1.0, 1.0, 0.7};
// What markers tell counts by this part: fields are no more than roughly Gaussian.
constexpr double kBelieved = 0.5;

constexpr double kPlaces = 0.42;  // [sides] how far from the middle the outer places are

/// Logarithms of the prior of each shift of the grid, up to a constant.
std::array<double, ShiftGrid::kShifts> shiftPrior(double usual, double none) {
  std::array<double, ShiftGrid::kShifts> weight{};
  double sum = 0.0;
  for (int k = 1; k < ShiftGrid::kShifts; ++k) {
    const double off = std::log(ShiftGrid::shift(k) / (kMedian * usual)) / kSpread;
    sum += weight[static_cast<std::size_t>(k)] = std::exp(-0.5 * off * off);
  }
  for (double& w : weight) w *= (1.0 - none) / sum;
  weight[0] = none;
  for (double& w : weight) w = w > 0.0 ? std::log(w) : -std::numeric_limits<double>::infinity();
  return weight;
}

}  // namespace

double shiftCorrelation(const Eigen::Vector2d& apart, double smoothness) {
  return std::exp(-apart.squaredNorm() / (4.0 * smoothness * smoothness));
}

double ShiftGrid::shift(int k) {
  static const auto kValues = [] {
    std::array<double, kShifts> values{};
    for (int i = 1; i < kShifts; ++i) {
      values[static_cast<std::size_t>(i)] = kSmallest * std::pow(kLargest / kSmallest, (i - 1.0) / (kShifts - 2.0));
    }
    return values;
  }();
  return kValues[static_cast<std::size_t>(k)];
}

double ShiftGrid::alike(int k) {
  return static_cast<double>(1 << k);
}

void ShiftField::add(const ShiftEvidence& evidence, double weight) {
  for (std::size_t i = 0; i < seen_.size(); ++i) seen_[i] += weight * evidence.log_likelihood[i];
}

ShiftEstimate ShiftField::estimate(double usual, bool as_modelled) const {
  const double expected = usual > 0.0 ? usual : kFirstUsual;
  const auto independent = shiftPrior(expected, as_modelled || !(usual > 0.0) ? kNone : 0.0);
  const auto together = shiftPrior(expected, 0.0);
  ShiftGrid::Table log_weight;
  ShiftGrid::forEach([&](int alike, int shift, int smooth, std::size_t i) {
    const double off = std::log(ShiftGrid::alike(alike)) / kAlikeSpread;
    const auto& prior = alike == 0 ? independent : together;
    log_weight[i] = kBelieved * seen_[i] - 0.5 * off * off + prior[static_cast<std::size_t>(shift)] +
                    std::log(kSmoothnessPrior[static_cast<std::size_t>(smooth)]);
  });
  const double most = *std::max_element(log_weight.begin(), log_weight.end());
  double sum = 0.0, alike_sum = 0.0, variance = 0.0, smoothness = 0.0;
  ShiftGrid::forEach([&](int alike, int shift, int smooth, std::size_t i) {
    const double weight = std::exp(log_weight[i] - most), v = ShiftGrid::shift(shift) * ShiftGrid::shift(shift);
    sum += weight;
    alike_sum += weight * ShiftGrid::alike(alike);
    variance += weight * v;
    smoothness += weight * v * ShiftGrid::kSmoothness[static_cast<std::size_t>(smooth)];
  });
  ShiftEstimate estimate;
  estimate.alike = alike_sum / sum;
  estimate.sigma = std::sqrt(variance / sum);
  if (variance > 0.0) estimate.smoothness = smoothness / variance;
  return estimate;
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
                                        const Eigen::Isometry3d& pose, double smoothness) {
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
      const double alike = shiftCorrelation(pixels[i] - pixels[k], smoothness);
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
