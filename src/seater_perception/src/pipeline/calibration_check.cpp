#include <algorithm>
#include <cmath>

#include "numerics/symmetric.h"
#include "pose/pose.h"
#include "seater_perception/report.h"

namespace seater_perception {
namespace {

constexpr int kUnknowns = 7, kRows = 8;  // pose and logarithm of the focal length; four corners
constexpr double kCornerSigma = 0.15;    // [px] what photographs show of corners (docs/results/photographs.md)
constexpr double kTells = 0.03;          // standard deviation from which on a check says nothing
// Calibrations are good to a percent or two; by this much a docked chair stands 1 to 2 cm off (1 m before the dock).
constexpr double kUsual = 0.015, kClearly = 4.0;  // [standard deviations]

/// Adds what one marker tells; false when a corner of it is not in front of the camera.
bool addMarker(const CameraModel& camera, const Eigen::Isometry3d& pose, const DockMarker& place,
               const DetectedMarker& seen, double placement_sigma, SmallMatrix& information, SmallVector& right) {
  SmallMatrix J(kRows, kUnknowns), by_place(kRows, 3);
  SmallVector off(kRows);
  const auto corners = markerCorners(place.size);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d arm = pose.linear() * (place.T_dock_marker() * corners[i]), point = arm + pose.translation();
    const auto pixel = camera.project(point);
    if (!pixel) return false;
    const auto row = static_cast<Eigen::Index>(2 * i);
    J.block<2, 6>(row, 0) = pixelByPose(camera, arm, point);
    J.block<2, 1>(row, 6) = *pixel - Eigen::Vector2d(camera.cx(), camera.cy());
    by_place.middleRows<2>(row) = camera.projectionJacobian(point);
    off.segment<2>(row) = seen.corners[i] - *pixel;
  }
  SmallMatrix covariance = placement_sigma * placement_sigma * by_place.lazyProduct(by_place.transpose());
  covariance.diagonal().array() += kCornerSigma * kCornerSigma;
  const auto weighted = solvedPositive(covariance, J);
  if (!weighted) return false;
  information += weighted->transpose().lazyProduct(J);
  right += weighted->transpose().lazyProduct(off);
  return true;
}

}  // namespace

bool FocalCheck::contradicts() const {
  return std::abs(excess) > std::max(kUsual, kClearly * sigma);
}

std::optional<FocalCheck> checkFocalLength(const CameraModel& camera, const DockLayout& layout,
                                           const DetectionResult& result, double placement_sigma) {
  if (result.dock.empty()) return std::nullopt;
  SmallMatrix information = SmallMatrix::Zero(kUnknowns, kUnknowns);
  SmallVector right = SmallVector::Zero(kUnknowns);
  int markers = 0;
  for (const DetectedMarker& seen : result.markers) {
    const auto place = layout.markers.find(seen.id);
    if (place == layout.markers.end() || seen.stage == PoseStage::corners) continue;
    if (!addMarker(camera, result.dock.front().pose, place->second, seen, placement_sigma, information, right))
      return std::nullopt;
    ++markers;
  }
  if (markers < 2) return std::nullopt;
  // Metres, radians and logarithms differ by orders of magnitude.
  const SmallVector scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const SmallMatrix scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const auto inverse = solvedPositive(scaled, SmallMatrix::Identity(kUnknowns, kUnknowns));
  if (!inverse) return std::nullopt;
  const SmallVector change = inverse->lazyProduct(scale.cwiseProduct(right));
  const FocalCheck check{-change[6] * scale[6], std::sqrt((*inverse)(6, 6)) * scale[6]};
  if (!(check.sigma < kTells) || !std::isfinite(check.excess)) return std::nullopt;
  return check;
}

}  // namespace seater_perception
