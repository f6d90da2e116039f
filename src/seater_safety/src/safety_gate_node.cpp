// ROS shell of the velocity gate. Topics (relative):
//   in   velocity_request (geometry_msgs/TwistStamped), user_cmd_vel (geometry_msgs/Twist),
//        emergency_stop (std_msgs/Bool)
//   out  cmd_vel (geometry_msgs/Twist), cmd_vel_stamped (geometry_msgs/TwistStamped, with the request's stamp)
// One output follows each input; a timer continues to brake when inputs end. All callbacks run in one thread.
// Time is ROS time, so that a simulation in lock-step does not depend on the speed of the machine.
#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>

#include <csignal>
#include <limits>
#include <stdexcept>
#include <string>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

double required(const ros::NodeHandle& handle, const std::string& key) {
  double value = std::numeric_limits<double>::quiet_NaN();
  if (!handle.getParam(key, value)) throw std::invalid_argument(handle.resolveName(key) + ": is missing or no number");
  return value;
}

GateParameters loadParameters(const ros::NodeHandle& handle) {
  GateParameters p;
  p.v_max = required(handle, "chair/limits/v_max");
  p.v_reverse_max = required(handle, "chair/limits/v_reverse_max");
  p.omega_max = required(handle, "chair/limits/omega_max");
  p.a_max = required(handle, "chair/limits/a_max");
  p.alpha_max = required(handle, "chair/limits/alpha_max");
  p.a_stop = required(handle, "safety/a_stop");
  p.alpha_stop = required(handle, "safety/alpha_stop");
  p.request_timeout = required(handle, "safety/request_timeout");
  p.user_timeout = required(handle, "safety/user_timeout");
  return p;
}

class SafetyGateNode {
 public:
  explicit SafetyGateNode(const GateParameters& parameters) : gate_(parameters) {
    command_ = handle_.advertise<geometry_msgs::Twist>("cmd_vel", 10);
    stamped_command_ = handle_.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10);
    request_ =
        handle_.subscribe("velocity_request", 10, &SafetyGateNode::onRequest, this, ros::TransportHints().tcpNoDelay());
    user_ = handle_.subscribe("user_cmd_vel", 1, &SafetyGateNode::onUser, this);
    emergency_stop_ = handle_.subscribe("emergency_stop", 1, &SafetyGateNode::onEmergencyStop, this);
    timer_ = handle_.createTimer(ros::Duration(0.02), &SafetyGateNode::onTimer, this);
    updater_.setHardwareID("seater_safety");
    updater_.add("velocity gate", this, &SafetyGateNode::diagnose);
  }

  // The last message is a zero velocity.
  void stop() {
    command_.publish(geometry_msgs::Twist());
    geometry_msgs::TwistStamped stamped;
    stamped.header.stamp = last_stamp_;
    stamped_command_.publish(stamped);
  }

 private:
  void onRequest(const geometry_msgs::TwistStamped& message) {
    last_stamp_ = message.header.stamp;
    const double now = VelocityGate::requestTime(ros::Time::now().toSec(), last_stamp_.toSec());
    gate_.request(now, {message.twist.linear.x, message.twist.angular.z});
    publish(now);
  }

  void onUser(const geometry_msgs::Twist& message) {
    const double now = ros::Time::now().toSec();
    gate_.user(now, {message.linear.x, message.angular.z});
    publish(now);
  }

  void onEmergencyStop(const std_msgs::Bool& message) {
    gate_.emergencyStop(message.data);
    publish(ros::Time::now().toSec());
  }

  // Recent requests set the pace of the output; the timer takes over when they end.
  void onTimer(const ros::TimerEvent&) {
    const double now = ros::Time::now().toSec();
    updater_.update();
    if (gate_.state() == GateState::kRequest && now - last_output_ < 0.1) return;
    if (gate_.state() == GateState::kStopped && silent_) return;
    publish(now);
    silent_ = gate_.state() == GateState::kStopped;
  }

  void publish(double now) {
    const Velocity velocity = gate_.output(now);
    if (gate_.state() == GateState::kRefused) ROS_ERROR_THROTTLE(1.0, "A velocity request was not finite; stopping.");
    geometry_msgs::TwistStamped stamped;
    stamped.header.stamp = last_stamp_;
    stamped.header.frame_id = "base_link";
    stamped.twist.linear.x = velocity.linear;
    stamped.twist.angular.z = velocity.angular;
    command_.publish(stamped.twist);
    stamped_command_.publish(stamped);
    last_output_ = now;
    silent_ = false;
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const GateState state = gate_.state();
    const bool fault = state == GateState::kRefused || state == GateState::kEmergencyStop || state == GateState::kStale;
    status.summary(fault ? DiagnosticStatus::WARN : DiagnosticStatus::OK, toString(state));
    status.add("requests refused (not finite)", gate_.refused());
    status.add("outputs limited", gate_.limited());
  }

  ros::NodeHandle handle_;
  VelocityGate gate_;
  ros::Publisher command_, stamped_command_;
  ros::Subscriber request_, user_, emergency_stop_;
  ros::Timer timer_;
  diagnostic_updater::Updater updater_;
  ros::Time last_stamp_;
  double last_output_ = 0.0;
  bool silent_ = false;
};

}  // namespace
}  // namespace seater_safety

int main(int argc, char** argv) {
  ros::init(argc, argv, "safety_gate", ros::init_options::NoSigintHandler);
  ros::NodeHandle private_handle("~");
  // The node's own handler, because ROS's closes the connections before the last zero is sent.
  static volatile std::sig_atomic_t interrupted = 0;
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  try {
    seater_safety::SafetyGateNode node(seater_safety::loadParameters(private_handle));
    while (ros::ok() && interrupted == 0) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.02));
    node.stop();
    ros::WallDuration(0.1).sleep();
  } catch (const std::invalid_argument& error) {
    ROS_FATAL("safety_gate: wrong parameter: %s", error.what());
    return 1;
  }
  ros::shutdown();
  return 0;
}
