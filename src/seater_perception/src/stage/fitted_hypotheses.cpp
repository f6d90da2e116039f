#include "stage/fitted_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seater_perception {
namespace {

// A robust chi-squared takes what a wrong branch does not explain for something that covers the print, as both branches
// would show it. Where one leaves so many times more unexplained than another, it is the branch. Chosen by hand.
constexpr double kFarWorse = 3.0;

bool explains(const PhotometricResult& result, double smallest) {
  return result.converged && result.explained > smallest;
}

}  // namespace

std::vector<PoseHypothesis> distinct(const std::vector<PhotometricBranch>& branches, double smallest) {
  std::vector<PoseHypothesis> hypotheses;
  double least = 1.0 - smallest;
  for (const auto& b : branches) least = b.result.converged ? std::min(least, 1.0 - b.result.explained) : least;
  const auto possible = [=](const PhotometricResult& result) {
    return explains(result, smallest) && 1.0 - result.explained <= kFarWorse * least;
  };
  double best = std::numeric_limits<double>::infinity();
  for (const auto& b : branches) best = possible(b.result) ? std::min(best, b.chi_square) : best;
  for (const auto& b : branches) {
    if (!possible(b.result)) continue;
    const auto same = [&](const PoseHypothesis& h) {
      return turnBetween(h.pose, b.result.pose) <
             0.5 * std::sqrt(b.result.covariance.bottomRightCorner<3, 3>().trace());
    };
    if (std::any_of(hypotheses.begin(), hypotheses.end(), same)) continue;
    PoseHypothesis h;
    h.pose = b.result.pose;
    h.covariance = b.result.covariance;
    h.chi_squared = b.chi_square - best;
    hypotheses.push_back(h);
  }
  return hypotheses;
}

void addModelError(const CameraModel& camera, Correspondences corners, double sigma,
                   std::vector<PoseHypothesis>& hypotheses) {
  if (!(sigma > 0.0)) return;
  for (double& s : corners.sigma) s = sigma;
  for (auto& h : hypotheses) {
    if (const auto covariance = poseCovariance(camera, corners, h.pose)) h.covariance += *covariance;
  }
}

void weighByPrior(std::vector<PoseHypothesis>& hypotheses, const PosePrior& prior, double tilt_sigma) {
  std::vector<double> cost;
  for (const auto& h : hypotheses) cost.push_back(h.chi_squared + tiltCost(h, prior, tilt_sigma));
  const double best = *std::min_element(cost.begin(), cost.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < cost.size(); ++i) sum += hypotheses[i].weight = std::exp(-0.5 * (cost[i] - best));
  for (auto& h : hypotheses) h.weight /= sum;
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.weight > b.weight; });
}

}  // namespace seater_perception
