#include "pose/dock_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "numerics/solve.h"

namespace seater_perception {
namespace {

/// A marker of the dock as one image shows it.
struct Sighting {
  const MarkerEstimate* seen;
  const DockMarker* place;
  Correspondences points;  // in the dock frame
};

using Group = std::vector<Sighting>;

Group sightings(const CameraModel& camera, const std::vector<MarkerEstimate>& markers, const DockLayout& layout,
                const PoseParameters& parameters) {
  Group group;
  for (const MarkerEstimate& marker : markers) {
    const auto place = layout.markers.find(marker.image.id);
    if (place == layout.markers.end()) continue;
    auto points = markerCorrespondences(camera, marker.image, marker.size, parameters);
    if (!points) continue;
    for (auto& point : points->object) point = place->second.T_dock_marker() * point;
    group.push_back({&marker, &place->second, *points});
  }
  std::sort(group.begin(), group.end(), [](const Sighting& a, const Sighting& b) { return a.place->id < b.place->id; });
  return group;
}

std::vector<DockHypothesis> named(const std::vector<PoseHypothesis>& hypotheses, const Group& group) {
  std::vector<DockHypothesis> result;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    DockHypothesis dock;
    static_cast<PoseHypothesis&>(dock) = hypothesis;
    for (const Sighting& s : group) dock.marker_ids.push_back(s.place->id);
    result.push_back(dock);
  }
  return result;
}

/// The marker's own hypotheses, seen from the dock's frame.
std::vector<PoseHypothesis> fromSingle(const Sighting& sighting) {
  const Eigen::Isometry3d T_marker_dock = sighting.place->T_dock_marker().inverse();
  std::vector<PoseHypothesis> result = sighting.seen->hypotheses;
  for (PoseHypothesis& hypothesis : result) {
    hypothesis.covariance = transportCovariance(hypothesis.covariance, hypothesis.pose, T_marker_dock);
    hypothesis.pose = hypothesis.pose * T_marker_dock;
  }
  return result;
}

std::vector<PoseHypothesis> fromGroup(const CameraModel& camera, const Group& group, const PosePrior& prior,
                                      const PoseParameters& parameters) {
  if (group.size() == 1) return fromSingle(group.front());
  Correspondences points;
  std::vector<Eigen::Isometry3d> initial;
  for (const Sighting& s : group) {
    points.append(s.points);
    for (const PoseHypothesis& h : fromSingle(s)) initial.push_back(h.pose);
  }
  auto result = refineAll(camera, points, initial);
  weigh(result, points.size(), prior, parameters.tilt_sigma);
  return result;
}

/// Largest reprojection error of one marker of the group, over what is believed of it; 1 is the limit.
double disagreement(const CameraModel& camera, const Group& group, const std::vector<PoseHypothesis>& hypotheses,
                    const PoseParameters& parameters) {
  if (hypotheses.empty()) return std::numeric_limits<double>::infinity();
  const Eigen::Isometry3d& pose = hypotheses.front().pose;
  double worst = 0.0;
  for (const Sighting& s : group) {
    const double distance = std::max(0.01, (pose * s.place->position).z());
    const double displaced = camera.fx() * parameters.placement_tolerance / distance;
    const double limit = largestError(s.seen->image.side(), parameters) + displaced;
    worst = std::max(worst, reprojectionError(camera, s.points, pose) / limit);
  }
  return worst;
}

/// The group without its member at `index`.
Group without(const Group& group, std::size_t index) {
  Group rest = group;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(index));
  return rest;
}

std::vector<DockHypothesis> singles(const Group& group, const PosePrior& prior, const PoseParameters& parameters) {
  std::vector<DockHypothesis> all;
  double sum = 0.0;
  for (const Sighting& s : group) {
    // Each marker is as credible as the other, but for how upright its poses are; within a marker that is weighed
    // already.
    std::vector<DockHypothesis> own = named(fromSingle(s), {s});
    double upright = 0.0;
    for (const DockHypothesis& h : own)
      upright += h.weight * std::exp(-0.5 * tiltCost(h, prior, parameters.tilt_sigma));
    for (DockHypothesis& h : own) {
      h.weight *= upright;
      sum += h.weight;
      all.push_back(h);
    }
  }
  for (DockHypothesis& h : all) h.weight = sum > 0.0 ? h.weight / sum : 1.0 / static_cast<double>(all.size());
  std::stable_sort(all.begin(), all.end(),
                   [](const DockHypothesis& a, const DockHypothesis& b) { return a.weight > b.weight; });
  return all;
}

std::vector<DockHypothesis> bundle(const CameraModel& camera, Group group, const PosePrior& prior,
                                   const PoseParameters& parameters) {
  auto hypotheses = fromGroup(camera, group, prior, parameters);
  while (group.size() > 1 && disagreement(camera, group, hypotheses, parameters) > 1.0) {
    if (group.size() == 2) return singles(group, prior, parameters);
    Group best_group;
    std::vector<PoseHypothesis> best;
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Group rest = without(group, i);
      const auto candidate = fromGroup(camera, rest, prior, parameters);
      const double measure = disagreement(camera, rest, candidate, parameters);
      if (i > 0 && !(measure < smallest)) continue;
      smallest = measure;
      best_group = rest;
      best = candidate;
    }
    group = best_group;
    hypotheses = best;
  }
  return named(hypotheses, group);
}

}  // namespace

std::vector<DockHypothesis> estimateDock(const CameraModel& camera, const std::vector<MarkerEstimate>& markers,
                                         const DockLayout& layout, const std::string& selection,
                                         const Eigen::Vector3d& up, const PoseParameters& parameters) {
  Group group = sightings(camera, markers, layout, parameters);
  if (group.empty()) return {};
  if (selection == "lowest_id") group.resize(1);
  PosePrior prior;
  prior.up = up;
  prior.object_up = Eigen::Vector3d::UnitZ();  // the dock's z; its markers' y
  auto hypotheses = bundle(camera, group, prior, parameters);
  dropImprobable(hypotheses, parameters.min_hypothesis_weight);
  return hypotheses;
}

void addPlacementError(const CameraModel& camera, const DockLayout& layout, double sigma,
                       std::vector<DockHypothesis>& dock) {
  for (DockHypothesis& h : dock) {
    Matrix6d all = Matrix6d::Zero(), spread = Matrix6d::Zero();
    for (const int id : h.marker_ids) {
      const DockMarker& marker = layout.markers.at(id);
      Matrix6d information = Matrix6d::Zero();
      for (const Eigen::Vector3d& corner : markerCorners(marker.size)) {
        const Eigen::Vector3d arm = h.pose.linear() * (marker.T_dock_marker() * corner);
        const Eigen::Matrix<double, 2, 6> J = pixelByPose(camera, arm, arm + h.pose.translation());
        information += J.transpose() * J;
      }
      all += information;
      // A displaced print looks as the dock displaced would.
      spread += information.leftCols<3>() * information.leftCols<3>().transpose();
    }
    const Matrix6d inverse = inverted(all);
    const Matrix6d covariance = h.covariance + sigma * sigma * (inverse * spread * inverse.transpose());
    if (covariance.allFinite()) h.covariance = 0.5 * (covariance + covariance.transpose());
  }
}

}  // namespace seater_perception
