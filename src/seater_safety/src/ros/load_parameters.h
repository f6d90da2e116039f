#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "seater_safety/gate_parameters.h"

namespace seater_safety {

// From chair/limits and safety below `handle`. Throws std::invalid_argument naming the full key: missing, no number,
// unknown (safety only: chair.yaml has other readers) or out of range.
GateParameters loadParameters(const ros::NodeHandle& handle);

// Names of the required sources of obstacles, ~obstacle_sources: words between spaces; not set: none.
std::vector<std::string> loadSources(const ros::NodeHandle& handle);

}  // namespace seater_safety
