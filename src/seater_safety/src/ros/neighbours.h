#pragma once

#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <seater_msgs/GateState.h>

#include <string>
#include <vector>

namespace seater_safety {

// Whether somebody else does what only one may do: publish what the gate publishes, or one of its inputs.
class Neighbours {
 public:
  // Listens to the gate's own topics cmd_vel and gate_state.
  explicit Neighbours(ros::NodeHandle& handle);

  // One known publisher for this input.
  void watch(const ros::Subscriber& input) { inputs_.push_back(input); }
  // Empty, or what is wrong.
  std::string check() const;

 private:
  void hear(const std::string& publisher);

  ros::Subscriber command_, state_;
  std::vector<ros::Subscriber> inputs_;
  std::string stranger_;  // the last other node that sent on one of the gate's own topics
};

}  // namespace seater_safety
