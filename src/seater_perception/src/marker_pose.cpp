#include "seater_perception/marker_pose.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "seater_perception/dock_layout.h"

namespace seater_perception {

std::optional<Correspondences> markerCorrespondences(const CameraModel& camera, const MarkerCorners& marker,
                                                     double size, const PoseParameters& parameters) {
  Correspondences points;
  const double sigma = marker.edges_fitted ? parameters.corner_sigma : parameters.corner_sigma_coarse;
  const auto corners = markerCorners(size);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!points.add(corners[i], marker.corners[i], sigma, camera)) return std::nullopt;
  }
  return points;
}

std::vector<Eigen::Isometry3d> squareSolutions(const Correspondences& corners) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> seen;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    object.emplace_back(corners.object[i].x(), corners.object[i].y(), corners.object[i].z());
    seen.emplace_back(corners.normalised[i].x(), corners.normalised[i].y());
  }
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(object, seen, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE_SQUARE);
  std::vector<Eigen::Isometry3d> solutions;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector3d r(rotations[i].at<double>(0), rotations[i].at<double>(1), rotations[i].at<double>(2));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    if (r.norm() > 0.0) pose.linear() = Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix();
    for (int k = 0; k < 3; ++k) pose.translation()[k] = translations[i].at<double>(k);
    if (pose.matrix().allFinite()) solutions.push_back(pose);
  }
  return solutions;
}

std::optional<DetectedMarker> estimateMarker(const CameraModel& camera, const MarkerCorners& marker, double size,
                                             const PosePrior& prior, const PoseParameters& parameters) {
  const auto points = markerCorrespondences(camera, marker, size, parameters);
  if (!points) return std::nullopt;
  DetectedMarker result;
  result.image = marker;
  result.size = size;
  result.hypotheses = refineAll(camera, *points, squareSolutions(*points));
  weigh(result.hypotheses, points->size(), prior, parameters.tilt_sigma);
  if (result.hypotheses.empty()) return std::nullopt;
  if (result.best().error > largestError(marker.side(), parameters)) return std::nullopt;
  if (result.hypotheses.size() > 1) {
    result.ambiguity = result.best().error / std::max(result.hypotheses[1].error, 1e-6);
  }
  return result;
}

}  // namespace seater_perception
