#pragma once

#include <optional>
#include <vector>

#include "pose/pose.h"
#include "seater_perception/parameters.h"

namespace seater_perception {

/// What a pose has to be compared with to be believed.
struct PosePrior {
  /// Unit vector pointing up, in the optical frame; without it every attitude is as probable.
  std::optional<Eigen::Vector3d> up;
  /// The direction of the object that points up when it stands upright (markers: y, docks: z).
  Eigen::Vector3d object_up = Eigen::Vector3d::UnitY();
};

/// Local minima of the reprojection error: each initial pose is refined and equal results are merged. Covariance
/// included (inflated when the residual cannot be explained by the corner's sigma); degenerate poses are left out.
/// Weights are not set.
std::vector<PoseHypothesis> refineAll(const CameraModel& camera, const Correspondences& points,
                                      const std::vector<Eigen::Isometry3d>& initial);

/// Sets the weights and sorts, most probable first: w ~ exp(-(c + m) / 2), where c is chi_squared (scaled down when
/// even the smallest is too large for the corners' sigma) and m the squared Mahalanobis distance of the object's tilt
/// from upright, plus the logarithm of its determinant; the tilt's covariance is tilt_sigma^2 and the pose's own
/// uncertainty. Weights add up to 1. `corners` is the number of points behind them.
void weigh(std::vector<PoseHypothesis>& hypotheses, std::size_t corners, const PosePrior& prior, double tilt_sigma);

/// How much larger than assumed the corners' variance must be for this residual of `corners` points to be possible; 1
/// when it is.
double inflation(double chi_squared, std::size_t corners);

/// Likelihood of the second most probable pose over that of the most probable one, by the image alone: exp((c1 - c2) /
/// 2), where c is chi_squared over `scale`. 0 when there is no second one. `hypotheses`: most probable first.
double ambiguity(const std::vector<PoseHypothesis>& hypotheses, double scale);

/// The part m of weigh()'s cost: what the prior says against a pose, up to a constant.
double tiltCost(const PoseHypothesis& hypothesis, const PosePrior& prior, double tilt_sigma);

/// Whether a pose's covariance says anything: rotation better than 2 rad, position than half the distance.
bool meaningful(const PoseHypothesis& hypothesis);

/// Leaves out what is less probable than the parameter min_hypothesis_weight; the rest adds up to 1 again.
template <typename Hypothesis>
void dropImprobable(std::vector<Hypothesis>& hypotheses, double min_weight) {
  std::vector<Hypothesis> kept;
  double sum = 0.0;
  for (const Hypothesis& h : hypotheses) {
    if (!kept.empty() && h.weight < min_weight) continue;
    kept.push_back(h);
    sum += h.weight;
  }
  for (Hypothesis& h : kept) h.weight /= sum;
  hypotheses = kept;
}

/// Largest reprojection error [px] with which a marker of this side [px] is believed.
double largestError(double side, const PoseParameters& parameters);

}  // namespace seater_perception
