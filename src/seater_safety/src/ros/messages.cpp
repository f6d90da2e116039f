#include "messages.h"

namespace seater_safety {

Velocity velocityOf(const geometry_msgs::Twist& message) {
  return {message.linear.x, message.angular.z};
}

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

bool differs(const seater_msgs::GateState& one, const seater_msgs::GateState& other) {
  return one.state != other.state || one.stopped_by != other.stopped_by || one.consent != other.consent ||
         one.motion_allowed != other.motion_allowed || one.emergency_stop != other.emergency_stop;
}

}  // namespace seater_safety
