#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "seater_perception/marker_family.h"

namespace seater_perception {

/// Corners of a marker of this side [m] in its own frame (x right, y up as the print is read, z out of the paper), in
/// the order top-left, top-right, bottom-right, bottom-left.
std::array<Eigen::Vector3d, 4> markerCorners(double size);

/// One printed marker standing upright at the dock.
struct DockMarker {
  int id = 0;
  double size = 0.0;                                   ///< side of the black square [m]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< centre in the dock frame [m]
  double normal_yaw = 0.0;                             ///< direction in which the print faces, about the dock's z [rad]

  /// Pose of the marker frame in the dock frame.
  Eigen::Isometry3d T_dock_marker() const;
};

/// What perception knows of a dock: marker family, sizes and places.
struct DockLayout {
  MarkerFamily family;
  std::map<int, DockMarker> markers;  ///< by id; empty when no dock is looked for
  /// Side [m] of every marker that is not in `markers`; without it, those are not reported.
  std::optional<double> size_of_others;

  /// Side of a marker [m]; nothing when it is not to be reported.
  std::optional<double> sizeOf(int id) const;
};

/// A layout without a dock: every marker of the family (given, or by its name) has this side [m]. Throws
/// ConfigurationError.
DockLayout layoutOfEqualMarkers(const MarkerFamily& family, double size);
DockLayout layoutOfEqualMarkers(const std::string& family, double size);

/// Reads the keys `dictionary` and `markers` of a dock file (config/docks/default.yaml) strictly; other top-level keys
/// belong to other readers and are ignored. `prefix` names the mapping in messages. Throws ConfigurationError.
DockLayout loadDockLayout(const YAML::Node& node, const std::string& prefix);

}  // namespace seater_perception
