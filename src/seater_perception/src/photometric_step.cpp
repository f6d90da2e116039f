// The normal equations of a photometric fit, solved.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "photometric_limits.h"
#include "seater_perception/photometric_problem.h"

namespace seater_perception {
namespace {

constexpr double kSmallestEigenvalue = 1e-10;  // of the normal matrix scaled to a unit diagonal
constexpr double kLargestTurn = 0.5;           // [rad] of a step
constexpr double kLargestMove = 0.5;           // of the distance

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

std::optional<PhotometricState> PhotometricProblem::step(const PhotometricState& state, double damping, double stretch,
                                                         double& length) const {
  const int n = 6 + blur_, residual = n + brightness_;
  SharedVector right;
  const Shared H = reduced(damping, right);
  const SharedVector scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Shared scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const SharedVector scaled_right = scale.cwiseProduct(right);
  const SharedVector change = stretch * scale.cwiseProduct(SharedVector(scaled.ldlt().solve(scaled_right)));
  if (!change.allFinite()) return std::nullopt;
  length = change.dot(H * change);
  PhotometricState next = state;
  next.pose.translation() += change.head<3>();
  const Eigen::Vector3d turn = change.segment<3>(3);
  if (turn.norm() > kLargestTurn || change.head<3>().norm() > kLargestMove * state.pose.translation().norm())
    return std::nullopt;
  if (turn.norm() > 0.0) {
    next.pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * state.pose.linear();
  }
  if (blur_ > 0) next.blur.uu += change[6];
  if (blur_ == 1) next.blur.vv += change[6];
  if (blur_ == 3) next.blur.uv += change[7], next.blur.vv += change[8];
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    if ((*samples_)[m].empty()) continue;
    if (blur_ > 0) keepPossible(next.blur, (*samples_)[m].rays_per_pixel);
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
  const Eigen::Matrix<double, 6, 1> d = poseDifference(a, b);
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
  const Eigen::SelfAdjointEigenSolver<Shared> solver(scaled);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[0] > kSmallestEigenvalue)) return std::nullopt;
  const Shared inverse =
      solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
  const Matrix6d result = scale.head<6>().asDiagonal() * inverse.topLeftCorner<6, 6>() * scale.head<6>().asDiagonal();
  if (!result.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (result + result.transpose()));
}

}  // namespace seater_perception
