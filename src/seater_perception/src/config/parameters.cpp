#include "seater_perception/parameters.h"

#include <Eigen/Geometry>

#include "seater_perception/errors.h"

namespace seater_perception {

Eigen::Vector3d CameraMount::upInOptical() const {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Eigen::Matrix3d R_base_link =
      (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX()))
          .toRotationMatrix();
  const Vector3d up_in_link = R_base_link.transpose() * Vector3d::UnitZ();
  return {-up_in_link.y(), -up_in_link.z(), up_in_link.x()};  // optical x = -y, y = -z, z = x of the link
}

PerceptionParameters loadPerceptionParameters(const YAML::Node& node, const std::string& prefix) {
  const auto parameters = loadStrict<PerceptionParameters>(node, prefix);
  const DetectorParameters& d = parameters.detector;
  std::vector<std::string> problems;
  const auto ordered = [&](int low, int high, const std::string& low_key, const std::string& high_key) {
    if (low <= high) return;
    problems.push_back(prefix + "/detector/" + low_key + ": is " + std::to_string(low) + ", must not exceed " +
                       high_key + " (" + std::to_string(high) + ")");
  };
  ordered(d.threshold_window_min, d.threshold_window_max, "threshold_window_min", "threshold_window_max");
  ordered(d.corner_window_min, d.corner_window_max, "corner_window_min", "corner_window_max");
  throwProblems(problems, "wrong parameters:");
  return parameters;
}

CameraMount loadCameraMount(const YAML::Node& node, const std::string& prefix) {
  return loadStrict<CameraMount>(node, prefix);
}

}  // namespace seater_perception
