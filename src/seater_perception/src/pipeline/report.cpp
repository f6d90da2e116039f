#include "seater_perception/report.h"

#include <cmath>
#include <sstream>

#include "pipeline/format.h"

namespace seater_perception {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += std::string("\\") + c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      result += format("\\u%04x", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + "\"";
}

/// A list of `count` numbers, `at(i)` each.
template <typename At>
std::string list(std::size_t count, At at) {
  std::string result = "[";
  for (std::size_t i = 0; i < count; ++i) result += (i ? ", " : "") + format("%.12g", static_cast<double>(at(i)));
  return result + "]";
}

std::string jsonPose(const PoseHypothesis& h) {
  const Eigen::Quaterniond q(h.pose.linear());
  const double quaternion[] = {q.x(), q.y(), q.z(), q.w()};
  return "\"position\": " + list(3, [&](std::size_t i) { return h.pose.translation()[static_cast<Eigen::Index>(i)]; }) +
         ", \"orientation\": " + list(4, [&](std::size_t i) { return quaternion[i]; }) +
         ", \"covariance\": " + list(36, [&](std::size_t i) { return h.covariance.data()[i]; }) +
         format(", \"reprojection_error\": %.12g, \"weight\": %.12g", h.error, h.weight);
}

std::string jsonMarker(const DetectedMarker& m) {
  const auto& c = m.corners;
  std::string corners;
  for (std::size_t i = 0; i < 4; ++i) {
    corners += (i ? ", " : "") + list(2, [&](std::size_t k) { return c[i][static_cast<Eigen::Index>(k)]; });
  }
  return format("{\"id\": %d, \"size\": %.12g, ", m.id, m.size) + "\"corners\": [" + corners + "], " +
         jsonPose(m.best()) +
         format(", \"ambiguity\": %.12g, \"side_px\": %.12g, \"stage\": \"%s\"}", m.ambiguity, m.side, nameOf(m.stage));
}

}  // namespace

Placement markerPlacement(const Eigen::Isometry3d& T_optical_marker) {
  const Eigen::Vector3d normal = T_optical_marker.linear().col(2);
  const Eigen::Vector3d t = T_optical_marker.translation();
  return {t.norm(), t.x(), std::atan2(normal.x(), -normal.z())};
}

Placement dockPlacement(const Eigen::Isometry3d& T_optical_dock) {
  const Eigen::Vector3d x_axis = T_optical_dock.linear().col(0);
  const Eigen::Vector3d t = T_optical_dock.translation();
  return {t.norm(), t.x(), std::atan2(-x_axis.x(), x_axis.z())};
}

std::string table(const DetectionResult& result) {
  if (result.markers.empty()) return "no markers found\n";
  std::string text = "   id  distance mm  lateral mm  angle deg  side px  error px  ambiguity  stage\n";
  for (const DetectedMarker& m : result.markers) {
    const Placement p = markerPlacement(m.best().pose);
    text += format("%5d  %11.1f  %10.1f  %9.2f  %7.1f  %8.3f  %9.2f  %s\n", m.id, 1e3 * p.distance, 1e3 * p.lateral,
                   kDegrees * p.angle, m.side, m.best().error, m.ambiguity, nameOf(m.stage));
  }
  for (const DockHypothesis& h : result.dock) {
    const Eigen::Vector3d t = h.pose.translation();
    std::string ids;
    for (const int id : h.marker_ids) ids += " " + std::to_string(id);
    text +=
        format("dock: x %.1f mm, y %.1f mm, z %.1f mm (optical frame), heading %.2f deg, weight %.2f, markers%s\n",
               1e3 * t.x(), 1e3 * t.y(), 1e3 * t.z(), kDegrees * dockPlacement(h.pose).angle, h.weight, ids.c_str());
  }
  return text;
}

std::string json(const std::string& image, const DetectionResult& result, const std::optional<std::string>& drawing) {
  std::string text = "{\"image\": " + quoted(image) + ", \"markers\": [";
  for (std::size_t i = 0; i < result.markers.size(); ++i) text += (i ? ", " : "") + jsonMarker(result.markers[i]);
  text += "], \"dock\": [";
  for (std::size_t i = 0; i < result.dock.size(); ++i) {
    const DockHypothesis& h = result.dock[i];
    text += (i ? ", {" : "{") + jsonPose(h) +
            ", \"marker_ids\": " + list(h.marker_ids.size(), [&](std::size_t k) { return h.marker_ids[k]; }) + "}";
  }
  text += format("], \"refused\": %d", result.refused);
  if (drawing) text += ", \"drawing\": " + quoted(*drawing);
  return text + "}";
}

}  // namespace seater_perception
