#include "stage/dock_stage.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "numerics/solve.h"
#include "pose/shift_field.h"
#include "stage/fitted_hypotheses.h"

namespace seater_perception {
namespace {

// [px] rms, between a marker's own corners and those of the joint pose: six times corner_sigma (0.05); chosen by hand.
constexpr double kDisplaced = 0.3;

/// A marker that the dock's pose rests on.
struct Member {
  const MarkerEstimate* seen;
  Correspondences corners;  // in the dock's frame, as it was seen
};

/// Of `ids`, those that layout and image have; nothing when a corner cannot be undistorted.
std::optional<std::vector<Member>> membersOf(const PhotometricContext& context, const DockLayout& layout,
                                             const std::vector<MarkerEstimate>& markers, const std::vector<int>& ids) {
  std::vector<Member> members;
  for (const MarkerEstimate& m : markers) {
    const auto place = layout.markers.find(m.image.id);
    if (place == layout.markers.end() || !std::count(ids.begin(), ids.end(), m.image.id)) continue;
    auto corners = markerCorrespondences(context.camera, m.image, m.size, context.pose);
    if (!corners) return std::nullopt;
    for (auto& point : corners->object) point = place->second.T_dock_marker() * point;
    members.push_back({&m, *corners});
  }
  return members;
}

bool photometric(const Member& m) {
  return m.seen->stage == PoseStage::photometric && m.seen->model_holds;
}

/// Distinct results of the joint fit of the members that the model holds for.
std::vector<PoseHypothesis> jointFit(const PhotometricContext& context, const DockLayout& layout,
                                     const std::vector<Member>& members, const std::vector<DockHypothesis>& dock) {
  std::vector<PatternPlacement> placements;
  double sum = 0.0, known = 0.0;
  for (const Member& m : members) {
    if (!photometric(m)) continue;
    const DockMarker& place = layout.markers.at(m.seen->image.id);
    placements.push_back({context.patterns.of(place.id), place.size, place.T_dock_marker()});
    if (m.seen->image.psf_sd > 0.0) sum += m.seen->image.psf_sd, known += 1.0;
  }
  std::vector<Eigen::Isometry3d> initial;
  for (const auto& h : dock) initial.push_back(h.pose);
  const double psf_sd = known > 0.0 ? sum / known : context.refiner.parameters().psf_sd;
  const PhotometricStart start{psf_sd, std::nullopt};
  return distinct(context.refiner.refineBranches(context.grey, context.camera, placements, initial, start),
                  kExplainedLarge);
}

/// What the corners of the other members tell: one step of least squares, all weighed by their covariances.
void addCorners(const CameraModel& camera, const std::vector<Member>& members, PoseHypothesis& hypothesis) {
  Matrix6d information = inverted(hypothesis.covariance);
  Vector6d right = Vector6d::Zero();
  const Eigen::Isometry3d pose = hypothesis.pose;
  for (const Member& m : members) {
    if (photometric(m)) continue;
    for (std::size_t i = 0; i < m.corners.size(); ++i) {
      const Eigen::Vector3d arm = pose.linear() * m.corners.object[i], point = arm + pose.translation();
      const auto pixel = camera.project(point);
      if (!pixel) return;
      const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, point) / m.corners.sigma[i];
      information += J.transpose() * J;
      right += J.transpose() * (m.corners.pixel[i] - *pixel) / m.corners.sigma[i];
    }
  }
  const Matrix6d covariance = inverted(information);
  if (!covariance.allFinite()) return;
  hypothesis.covariance = 0.5 * (covariance + covariance.transpose());
  hypothesis.pose = movedPose(pose, hypothesis.covariance * right);
}

}  // namespace

RefinedDock refineDock(const PhotometricContext& context, const DockLayout& layout, const Eigen::Vector3d& up,
                       const std::vector<MarkerEstimate>& markers, const std::vector<DockHypothesis>& dock) {
  if (dock.empty()) return {DockOutcome::too_few, dock};
  const std::vector<int>& ids = dock.front().marker_ids;
  const auto rests_on_others = [&ids](const DockHypothesis& h) { return h.marker_ids != ids; };
  if (std::any_of(dock.begin(), dock.end(), rests_on_others)) return {DockOutcome::contradictory, dock};
  const auto members = membersOf(context, layout, markers, ids);
  if (!members || std::count_if(members->begin(), members->end(), photometric) < 2) return {DockOutcome::too_few, dock};
  auto hypotheses = jointFit(context, layout, *members, dock);
  const auto displaced = [&](const PoseHypothesis& h) {
    return std::any_of(members->begin(), members->end(), [&](const Member& m) {
      return photometric(m) && reprojectionError(context.camera, m.corners, h.pose) > kDisplaced;
    });
  };
  hypotheses.erase(std::remove_if(hypotheses.begin(), hypotheses.end(), displaced), hypotheses.end());
  if (hypotheses.empty()) return {DockOutcome::displaced, dock};
  ShiftedPlaces places;
  for (const Member& m : *members) {
    const DockMarker& place = layout.markers.at(m.seen->image.id);
    if (photometric(m)) places.add(place.size, place.T_dock_marker(), m.seen->shift_sigma);
  }
  for (auto& h : hypotheses) {
    if (const auto covariance = shiftCovariance(context.camera, places, h.pose)) h.covariance += *covariance;
    addCorners(context.camera, *members, h);
  }
  PosePrior prior;
  prior.up = up;
  prior.object_up = Eigen::Vector3d::UnitZ();
  weighByPrior(hypotheses, prior, context.pose.tilt_sigma);
  RefinedDock refined{DockOutcome::refined, {}};
  for (const auto& h : hypotheses) {
    DockHypothesis d;
    static_cast<PoseHypothesis&>(d) = h;
    d.error = dock.front().error;
    d.marker_ids = ids;
    refined.dock.push_back(d);
  }
  dropImprobable(refined.dock, context.pose.min_hypothesis_weight);
  return refined;
}

}  // namespace seater_perception
