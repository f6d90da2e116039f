// The normal equations of a photometric fit, solved.
#include <cmath>

#include "numerics/symmetric.h"
#include "photometric/evaluation.h"
#include "photometric/photometric_problem.h"
#include "pose/pose.h"

namespace seater_perception {
namespace {

// Trace of the inverse of the normal matrix scaled to a unit diagonal: double precision leaves six digits of such an
// inverse. Chosen by hand.
constexpr double kLargestInverse = 1e10;
// A step farther than these leaves what the linearisation holds for; damping then shortens it. Chosen by hand.
constexpr double kLargestTurn = 0.5;  // [rad] of a step
constexpr double kLargestMove = 0.5;  // of the distance

}  // namespace

Evaluation::Own Evaluation::brightnessInformation(std::size_t m, double damping) const {
  const int first = 6 + problem_->psfUnknowns(), unknowns = problem_->brightnessUnknowns();
  Own H = data_->blocks[m].block(first, first, unknowns, unknowns);
  if (unknowns >= 4) H.diagonal().segment<2>(2).array() += data_->slope_damping;
  if (unknowns == 5) H(4, 4) += data_->rim_damping;
  H.diagonal() *= 1.0 + damping;
  H.diagonal().array() += 1e-9;
  return H;
}

Evaluation::Shared Evaluation::reduced(double damping, SharedVector& right) const {
  using Mixed = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;
  const int own = problem_->brightnessUnknowns(), n = 6 + problem_->psfUnknowns(), residual = n + own;
  Shared H = Shared::Zero(n, n), correction = Shared::Zero(n, n);
  right = SharedVector::Zero(n);
  for (std::size_t m = 0; m < data_->blocks.size(); ++m) {
    if (problem_->samples()[m].empty()) continue;
    const EvaluationPool::Block& block = data_->blocks[m];
    const Mixed mixed = block.block(0, n, n, own);
    const Mixed solved = solvedSymmetricColumns(brightnessInformation(m, damping), SmallMatrix(mixed.transpose()));
    H += block.topLeftCorner(n, n);
    correction.noalias() += mixed * solved;
    right += block.col(residual).head(n) - solved.transpose() * block.col(residual).segment(n, own);
  }
  H.diagonal() *= 1.0 + damping;
  return H - correction;
}

SpreadCovariance Evaluation::psfAfter(SpreadCovariance psf, const SharedVector& change) const {
  const int unknowns = problem_->psfUnknowns();
  if (unknowns > 0) psf.uu += change[6];
  if (unknowns == 1) psf.vv += change[6];
  if (unknowns == 3) psf.uv += change[7], psf.vv += change[8];
  return psf;
}

Evaluation::Step Evaluation::step(double damping, double stretch) const {
  const PhotometricState& state = data_->state;
  const int psf_unknowns = problem_->psfUnknowns(), brightness_unknowns = problem_->brightnessUnknowns();
  const int n = 6 + psf_unknowns, residual = n + brightness_unknowns;
  Step result;
  SharedVector right;
  const Shared H = reduced(damping, right);
  // The first `used` unknowns; the others stay.
  const auto solve = [&](int used) {
    const Shared part = H.topLeftCorner(used, used);
    const SharedVector scale = part.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Shared scaled = scale.asDiagonal() * part * scale.asDiagonal();
    const SharedVector scaled_right = scale.cwiseProduct(right.head(used));
    SharedVector change = SharedVector::Zero(n);
    change.head(used) = stretch * scale.cwiseProduct(solvedSymmetric(scaled, scaled_right));
    return change;
  };
  SharedVector change = solve(n);
  SpreadCovariance psf = psfAfter(state.psf, change);
  // Where the point spread function would leave what the model can say, it goes to the limit, and the pose takes the
  // step without it.
  if (psf_unknowns > 0 && change.allFinite() && problem_->limitPsf(psf)) change = solve(6);
  if (!change.allFinite()) return result;
  result.squared_length = change.dot(H * change);
  PhotometricState next = state;
  const double turn = change.segment<3>(3).norm(), way = change.head<3>().norm();
  if (turn > kLargestTurn || way > kLargestMove * state.pose.translation().norm()) return result;
  next.pose = movedPose(state.pose, change.head<6>());
  next.psf = psf;
  for (std::size_t m = 0; m < data_->blocks.size(); ++m) {
    if (problem_->samples()[m].empty()) continue;
    const EvaluationPool::Block& block = data_->blocks[m];
    using OwnVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1>;
    const OwnVector open = stretch * block.col(residual).segment(n, brightness_unknowns) -
                           block.block(n, 0, brightness_unknowns, n) * change;
    const OwnVector own = solvedSymmetric(brightnessInformation(m, damping), open);
    if (!own.allFinite()) return result;
    Brightness& b = next.brightness[m];
    b.offset += own[0];
    b.gain += own[1];
    if (brightness_unknowns >= 4) b.slope_u += own[2], b.slope_v += own[3];
    if (brightness_unknowns == 5) b.rim += own[4];
  }
  result.state = std::move(next);
  return result;
}

double Evaluation::distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  SharedVector right;
  const Vector6d d = poseDifference(a, b);
  const Shared H = reduced(0.0, right);
  // The point spread function follows the pose.
  const int psf = problem_->psfUnknowns();
  const Matrix6d pose = H.topLeftCorner<6, 6>();
  if (psf == 0) return d.dot(pose * d);
  const SharedVector mixed = H.bottomLeftCorner(psf, 6) * d;
  return d.dot(pose * d) - mixed.dot(solvedSymmetric(H.bottomRightCorner(psf, psf), mixed));
}

std::optional<Matrix6d> Evaluation::inversePoseInformation() const {
  SharedVector right;
  const Shared H = reduced(0.0, right);
  const SharedVector scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Shared scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const auto inverse = solvedPositive(scaled, SmallMatrix::Identity(scaled.rows(), scaled.cols()));
  if (!inverse || !(inverse->trace() < kLargestInverse)) return std::nullopt;
  const Matrix6d result = scale.head<6>().asDiagonal() * inverse->topLeftCorner<6, 6>() * scale.head<6>().asDiagonal();
  if (!result.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (result + result.transpose()));
}

}  // namespace seater_perception
