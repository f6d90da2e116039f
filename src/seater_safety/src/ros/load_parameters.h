#pragma once

#include <ros/node_handle.h>

#include "seater_safety/gate_parameters.h"

namespace seater_safety {

// From chair/limits and safety below `handle`. Throws std::invalid_argument naming the full key: missing, no number,
// unknown (safety only: chair.yaml has other readers) or out of range.
GateParameters loadParameters(const ros::NodeHandle& handle);

}  // namespace seater_safety
