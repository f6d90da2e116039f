#pragma once

#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <ros/ros.h>
#include <seater_msgs/GateState.h>

#include <cstdint>

#include "seater_safety/gate_state.h"

namespace seater_safety {

// What the gate sends: cmd_vel and cmd_vel_stamped, motor_enable, gate_state.
class Outputs {
 public:
  explicit Outputs(ros::NodeHandle& handle);

  // `stamp`: of the request that the command comes from.
  void command(const Velocity& velocity, const ros::Time& stamp);
  void enable(bool motors);
  void state(const GateStatus& status, std::uint64_t consent);
  // The same, where it is news.
  void stateIfChanged(const GateStatus& status, std::uint64_t consent);

 private:
  ros::Publisher command_, stamped_command_, enable_, state_;
  seater_msgs::GateState last_state_;
};

}  // namespace seater_safety
