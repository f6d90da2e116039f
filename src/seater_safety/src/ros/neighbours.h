#pragma once

#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <seater_msgs/GateState.h>

#include <cstddef>
#include <string>
#include <vector>

namespace seater_safety {

// Whether somebody else does what only one may do: publish what the gate publishes, or one of its inputs.
class Neighbours {
 public:
  // Listens to the gate's own topics cmd_vel and gate_state.
  explicit Neighbours(ros::NodeHandle& handle);

  // One known publisher for this input, or as many as `allowed`.
  void watch(const ros::Subscriber& input, std::size_t allowed = 1) { inputs_.push_back({input, allowed}); }
  // Empty, or what is wrong.
  std::string check() const;

 private:
  void hear(const std::string& publisher);

  struct Input {
    ros::Subscriber subscriber;
    std::size_t allowed;
  };

  ros::Subscriber command_, state_;
  std::vector<Input> inputs_;
  std::string stranger_;  // the last other node that sent on one of the gate's own topics
};

}  // namespace seater_safety
