// The normal equations of a photometric fit, solved.
#include <Eigen/Cholesky>
#include <cmath>

#include "photometric/photometric_problem.h"
#include "photometric/samples/photometric_limits.h"
#include "pose/pose.h"

namespace seater_perception {
namespace {

constexpr double kLargestInverse = 1e10;  // trace of the inverse of the normal matrix scaled to a unit diagonal
constexpr double kLimited = 1e-9;         // [px^2]
constexpr double kLargestTurn = 0.5;      // [rad] of a step
constexpr double kLargestMove = 0.5;      // of the distance

}  // namespace

PhotometricProblem::Own PhotometricProblem::brightnessInformation(std::size_t m, double damping) const {
  Own H = blocks_[m].block(6 + blur_, 6 + blur_, brightness_, brightness_);
  if (brightness_ >= 4) H.diagonal().segment<2>(2).array() += slope_damping_;
  if (brightness_ == 5) H(4, 4) += rim_damping_;
  H.diagonal() *= 1.0 + damping;
  H.diagonal().array() += 1e-9;
  return H;
}

PhotometricProblem::Shared PhotometricProblem::reduced(double damping, SharedVector& right) const {
  using Mixed = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9>;
  const int n = 6 + blur_, residual = n + brightness_;
  Shared H = Shared::Zero(n, n), correction = Shared::Zero(n, n);
  right = SharedVector::Zero(n);
  for (std::size_t m = 0; m < blocks_.size(); ++m) {
    if ((*samples_)[m].empty()) continue;
    const Block& block = blocks_[m];
    const Mixed mixed = block.block(0, n, n, brightness_);
    const Mixed solved = brightnessInformation(m, damping).ldlt().solve(Mixed(mixed.transpose()));
    H += block.topLeftCorner(n, n);
    correction.noalias() += mixed * solved;
    right += block.col(residual).head(n) - solved.transpose() * block.col(residual).segment(n, brightness_);
  }
  H.diagonal() *= 1.0 + damping;
  return H - correction;
}

SpreadCovariance PhotometricProblem::blurAfter(SpreadCovariance blur, const SharedVector& change) const {
  if (blur_ > 0) blur.uu += change[6];
  if (blur_ == 1) blur.vv += change[6];
  if (blur_ == 3) blur.uv += change[7], blur.vv += change[8];
  return blur;
}

bool PhotometricProblem::limitBlur(SpreadCovariance& blur) const {
  const SpreadCovariance before = blur;
  for (const MarkerSamples& samples : *samples_) {
    if (!samples.empty()) keepPossible(blur, samples.rays_per_pixel);
  }
  return std::abs(blur.uu - before.uu) + std::abs(blur.vv - before.vv) + std::abs(blur.uv - before.uv) > kLimited;
}

std::optional<PhotometricState> PhotometricProblem::step(const PhotometricState& state, double damping, double stretch,
                                                         double& length) const {
  const int n = 6 + blur_, residual = n + brightness_;
  SharedVector right;
  const Shared H = reduced(damping, right);
  // The first `used` unknowns; the others stay.
  const auto solve = [&](int used) {
    const Shared part = H.topLeftCorner(used, used);
    const SharedVector scale = part.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Shared scaled = scale.asDiagonal() * part * scale.asDiagonal();
    const SharedVector scaled_right = scale.cwiseProduct(right.head(used));
    SharedVector change = SharedVector::Zero(n);
    change.head(used) = stretch * scale.cwiseProduct(SharedVector(scaled.ldlt().solve(scaled_right)));
    return change;
  };
  SharedVector change = solve(n);
  SpreadCovariance blur = blurAfter(state.blur, change);
  // Where the blur would leave what the model can say, it goes to the limit, and the pose takes the step without it.
  if (blur_ > 0 && change.allFinite() && limitBlur(blur)) change = solve(6);
  if (!change.allFinite()) return std::nullopt;
  length = change.dot(H * change);
  PhotometricState next = state;
  const double turn = change.segment<3>(3).norm(), way = change.head<3>().norm();
  if (turn > kLargestTurn || way > kLargestMove * state.pose.translation().norm()) return std::nullopt;
  next.pose = movedPose(state.pose, change.head<6>());
  next.blur = blur;
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    if ((*samples_)[m].empty()) continue;
    const Block& block = blocks_[m];
    using OwnVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1>;
    const OwnVector open =
        stretch * block.col(residual).segment(n, brightness_) - block.block(n, 0, brightness_, n) * change;
    const OwnVector own = brightnessInformation(m, damping).ldlt().solve(open);
    if (!own.allFinite()) return std::nullopt;
    Brightness& b = next.brightness[m];
    b.offset += own[0];
    b.gain += own[1];
    if (brightness_ >= 4) b.slope_u += own[2], b.slope_v += own[3];
    if (brightness_ == 5) b.rim += own[4];
  }
  return next;
}

double PhotometricProblem::distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  SharedVector right;
  const Vector6d d = poseDifference(a, b);
  const Shared H = reduced(0.0, right);
  // The blur follows the pose.
  const Matrix6d pose = H.topLeftCorner<6, 6>();
  if (blur_ == 0) return d.dot(pose * d);
  const SharedVector mixed = H.bottomLeftCorner(blur_, 6) * d;
  return d.dot(pose * d) - mixed.dot(SharedVector(Shared(H.bottomRightCorner(blur_, blur_)).ldlt().solve(mixed)));
}

std::optional<Matrix6d> PhotometricProblem::inversePoseInformation() const {
  SharedVector right;
  const Shared H = reduced(0.0, right);
  const SharedVector scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Shared scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::LLT<Shared> factor(scaled);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Shared inverse = factor.solve(Shared::Identity(scaled.rows(), scaled.cols()));
  if (!(inverse.trace() < kLargestInverse)) return std::nullopt;
  const Matrix6d result = scale.head<6>().asDiagonal() * inverse.topLeftCorner<6, 6>() * scale.head<6>().asDiagonal();
  if (!result.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (result + result.transpose()));
}

}  // namespace seater_perception
