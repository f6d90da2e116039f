#pragma once

#include <ros/node_handle.h>

#include <string>

#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"

namespace seater_perception {

/// The node's private parameters.
struct NodeParameters {
  DockLayout dock;                  ///< ~dock: a file of config/docks
  std::string dock_name;            ///< ~dock/name; empty (default): it is not told apart from others
  PerceptionParameters perception;  ///< ~perception: config/perception.yaml
  CameraMount mount;                ///< ~chair/camera (config/chair.yaml)
  bool rectified = false;           ///< ~rectified: images are rectified (P) or raw (K, D); required
  std::string image_transport;      ///< ~image_transport: raw (default) or compressed
  std::string odometry_frame;       ///< ~odometry_frame: TF frame of the odometry; empty (default): without odometry
  bool lazy = true;                 ///< ~lazy: subscribe to the camera only while someone listens
};

/// Throws ConfigurationError with every problem, each with its full key.
NodeParameters loadNodeParameters(const ros::NodeHandle& private_handle);

/// A tree of the parameter server as YAML. Text keeps its quotes, so that it never passes for a number.
YAML::Node toYaml(const XmlRpc::XmlRpcValue& value);

}  // namespace seater_perception
