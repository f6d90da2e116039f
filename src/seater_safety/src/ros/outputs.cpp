#include "outputs.h"

#include <std_msgs/Bool.h>

namespace seater_safety {
namespace {

geometry_msgs::TwistStamped commandMessage(const Velocity& velocity, const ros::Time& stamp) {
  geometry_msgs::TwistStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = "base_link";
  message.twist.linear.x = velocity.linear;
  message.twist.angular.z = velocity.angular;
  return message;
}

seater_msgs::GateState stateMessage(const GateStatus& status, std::uint64_t consent, const ros::Time& stamp) {
  seater_msgs::GateState message;
  message.header.stamp = stamp;
  message.state = static_cast<std::uint8_t>(status.state);
  message.stopped_by = static_cast<std::uint8_t>(status.stopped_by);
  message.reason = status.reason;
  message.stop_reason = status.stop_reason;
  message.motion_allowed = status.motion_allowed;
  message.consent = consent;
  message.holder = status.holder;
  message.emergency_stop = status.emergency_stop;
  message.request_age = static_cast<float>(status.request_age);
  message.user_age = static_cast<float>(status.user_age);
  message.emergency_stop_age = static_cast<float>(status.emergency_stop_age);
  return message;
}

// Whether people and nodes have to hear of the change from one to the other at once.
bool differs(const seater_msgs::GateState& one, const seater_msgs::GateState& other) {
  return one.state != other.state || one.stopped_by != other.stopped_by || one.consent != other.consent ||
         one.motion_allowed != other.motion_allowed || one.emergency_stop != other.emergency_stop;
}

}  // namespace

Outputs::Outputs(ros::NodeHandle& handle)
    : command_(handle.advertise<geometry_msgs::Twist>("cmd_vel", 10)),
      stamped_command_(handle.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10)),
      enable_(handle.advertise<std_msgs::Bool>("motor_enable", 10)),
      state_(handle.advertise<seater_msgs::GateState>("gate_state", 10, true)) {}

void Outputs::command(const Velocity& velocity, const ros::Time& stamp) {
  const geometry_msgs::TwistStamped message = commandMessage(velocity, stamp);
  command_.publish(message.twist);
  stamped_command_.publish(message);
}

void Outputs::enable(bool motors) {
  std_msgs::Bool message;
  message.data = static_cast<std::uint8_t>(motors);
  enable_.publish(message);
}

void Outputs::state(const GateStatus& status, std::uint64_t consent) {
  last_state_ = stateMessage(status, consent, ros::Time::now());
  state_.publish(last_state_);
}

void Outputs::stateIfChanged(const GateStatus& status, std::uint64_t consent) {
  if (differs(stateMessage(status, consent, ros::Time()), last_state_)) state(status, consent);
}

}  // namespace seater_safety
