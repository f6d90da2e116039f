#pragma once

#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <seater_msgs/GateState.h>

#include <cstdint>

#include "seater_safety/gate_state.h"

namespace seater_safety {

Velocity velocityOf(const geometry_msgs::Twist& message);
geometry_msgs::TwistStamped commandMessage(const Velocity& velocity, const ros::Time& stamp);
seater_msgs::GateState stateMessage(const GateStatus& status, std::uint64_t consent, const ros::Time& stamp);

// Whether people and nodes have to hear of the change from one to the other at once.
bool differs(const seater_msgs::GateState& one, const seater_msgs::GateState& other);

}  // namespace seater_safety
