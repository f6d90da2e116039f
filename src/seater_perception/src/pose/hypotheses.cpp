#include "pose/hypotheses.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// A chi-squared of 2 degrees of freedom (one marker: 8 coordinates, 6 unknowns) exceeds it once in 1000 times: 2 ln
// 1000. With more degrees of freedom, the limit grows by their mean and by three standard deviations of the additional
// ones.
constexpr double kChanceLimit = 13.8;
// A rotation with a standard deviation above 2 rad is anywhere (uniform over a half turn to both sides: 1.8 rad); a
// distance known to no better than its half may be zero at two standard deviations. Chosen by that reasoning.
constexpr double kMaxRotationSigma = 2.0;  // [rad]
constexpr double kMaxPositionSigma = 0.5;  // of the distance
// Ambiguity stays below e^5 = 148 where the prior has overruled the image; any larger number says the same.
constexpr double kLargestLogRatio = 5.0;

}  // namespace

double inflation(double chi_squared, std::size_t corners) {
  const double freedom = 2.0 * static_cast<double>(corners) - 6.0;
  const double limit = freedom + kChanceLimit - 2.0 + 3.0 * std::sqrt(2.0 * (freedom - 2.0));
  return chi_squared > limit ? chi_squared / freedom : 1.0;
}

double ambiguity(const std::vector<PoseHypothesis>& hypotheses, double scale) {
  if (hypotheses.size() < 2) return 0.0;
  const double difference = (hypotheses[0].chi_squared - hypotheses[1].chi_squared) / scale;
  return std::exp(std::min(kLargestLogRatio, 0.5 * difference));
}

bool meaningful(const PoseHypothesis& hypothesis) {
  const double rotation = std::sqrt(hypothesis.covariance.diagonal().tail<3>().maxCoeff());
  const double position = std::sqrt(hypothesis.covariance.diagonal().head<3>().maxCoeff());
  return rotation < kMaxRotationSigma && position < kMaxPositionSigma * hypothesis.pose.translation().norm();
}

std::vector<PoseHypothesis> refineAll(const CameraModel& camera, const Correspondences& points,
                                      const std::vector<Eigen::Isometry3d>& initial) {
  std::vector<PoseHypothesis> result;
  for (const Eigen::Isometry3d& start : initial) {
    const auto pose = refinePose(points, start);
    if (!pose) continue;
    const auto same = [&](const PoseHypothesis& other) { return samePose(*pose, other.pose); };
    if (std::any_of(result.begin(), result.end(), same)) continue;
    PoseHypothesis hypothesis;
    hypothesis.pose = *pose;
    hypothesis.error = reprojectionError(camera, points, *pose);
    hypothesis.chi_squared = chiSquared(camera, points, *pose);
    const auto covariance = poseCovariance(camera, points, *pose);
    if (!covariance || !std::isfinite(hypothesis.error)) continue;
    hypothesis.covariance = inflation(hypothesis.chi_squared, points.size()) * *covariance;
    if (meaningful(hypothesis)) result.push_back(hypothesis);
  }
  return result;
}

double tiltCost(const PoseHypothesis& hypothesis, const PosePrior& prior, double tilt_sigma) {
  if (!prior.up) return 0.0;
  const Eigen::Matrix3d& R = hypothesis.pose.linear();
  const Eigen::Vector3d& up = *prior.up;
  const Eigen::Vector3d object_up = R * prior.object_up;
  // Two axes square to the object's up: their components along the true up vanish when it stands upright.
  const Eigen::Vector3d a = object_up.unitOrthogonal();
  const Eigen::Vector3d b = object_up.cross(a);
  Eigen::Vector2d tilt(a.dot(up), b.dot(up));
  const double sine = tilt.norm();
  const double angle = std::atan2(sine, object_up.dot(up));
  if (sine > 1e-9)
    tilt *= angle / sine;
  else if (angle > 1.0)
    tilt = Eigen::Vector2d(angle, 0.0);  // exactly upside down
  Eigen::Matrix<double, 2, 3> by_rotation;
  by_rotation << a.cross(up).transpose(), b.cross(up).transpose();
  const Eigen::Matrix2d S = by_rotation * hypothesis.covariance.bottomRightCorner<3, 3>() * by_rotation.transpose() +
                            tilt_sigma * tilt_sigma * Eigen::Matrix2d::Identity();
  return tilt.dot(S.inverse() * tilt) + std::log(S.determinant());
}

void weigh(std::vector<PoseHypothesis>& hypotheses, std::size_t corners, const PosePrior& prior, double tilt_sigma) {
  if (hypotheses.empty()) return;
  std::vector<double> cost;
  double smallest = hypotheses.front().chi_squared;
  for (const auto& h : hypotheses) smallest = std::min(smallest, h.chi_squared);
  const double scale = inflation(smallest, corners);
  for (const auto& h : hypotheses) cost.push_back(h.chi_squared / scale + tiltCost(h, prior, tilt_sigma));
  const double best = *std::min_element(cost.begin(), cost.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    hypotheses[i].weight = std::exp(-0.5 * (cost[i] - best));
    sum += hypotheses[i].weight;
  }
  for (auto& h : hypotheses) h.weight /= sum;
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.weight > b.weight; });
}

double largestError(double side, const PoseParameters& parameters) {
  return std::max(parameters.max_reprojection_error, parameters.max_reprojection_fraction * side);
}

}  // namespace seater_perception
