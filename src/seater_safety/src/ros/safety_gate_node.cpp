// ROS shell of the velocity gate. Topics and service (relative):
//   in   velocity_request (geometry_msgs/TwistStamped), user_cmd_vel (geometry_msgs/Twist),
//        emergency_stop (std_msgs/Bool); gate_arm (seater_msgs/GateArm): consent for one goal, of the calling node
//   out  cmd_vel (geometry_msgs/Twist), cmd_vel_stamped (geometry_msgs/TwistStamped, with the request's stamp),
//        gate_state (seater_msgs/GateState)
// One output follows each input; a timer continues to brake when inputs end. All callbacks run in one thread.
// Time is ROS time, so that a simulation in lock-step does not depend on the speed of the machine.
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <seater_msgs/GateArm.h>
#include <std_msgs/Bool.h>

#include <algorithm>
#include <csignal>
#include <limits>
#include <stdexcept>

#include "load_parameters.h"
#include "messages.h"
#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

constexpr double kStatePeriod = 0.1;  // [s] of wall time between two gate_state without a change

class SafetyGateNode {
 public:
  explicit SafetyGateNode(const GateParameters& parameters) : gate_(parameters) {
    const ros::TransportHints prompt = ros::TransportHints().tcpNoDelay();
    command_ = handle_.advertise<geometry_msgs::Twist>("cmd_vel", 10);
    stamped_command_ = handle_.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10);
    state_ = handle_.advertise<seater_msgs::GateState>("gate_state", 10, true);
    request_ = handle_.subscribe("velocity_request", 10, &SafetyGateNode::onRequest, this, prompt);
    user_ = handle_.subscribe("user_cmd_vel", 1, &SafetyGateNode::onUser, this, prompt);
    emergency_stop_ = handle_.subscribe("emergency_stop", 10, &SafetyGateNode::onEmergencyStop, this, prompt);
    arm_ = handle_.advertiseService("gate_arm", &SafetyGateNode::onArm, this);
    timer_ = handle_.createTimer(ros::Duration(0.02), &SafetyGateNode::onTimer, this);
    state_timer_ = handle_.createWallTimer(ros::WallDuration(kStatePeriod), &SafetyGateNode::onStateTimer, this);
    updater_.setHardwareID("seater_safety");
    updater_.add("velocity gate", this, &SafetyGateNode::diagnose);
  }

  // The last message is a zero velocity.
  void stop() { send(Velocity{}); }

 private:
  static double now() { return ros::Time::now().toSec(); }

  void onRequest(const ros::MessageEvent<geometry_msgs::TwistStamped const>& event) {
    const geometry_msgs::TwistStamped& message = *event.getConstMessage();
    last_stamp_ = message.header.stamp;
    const double stamp = last_stamp_.toSec();
    const double age = last_stamp_.isZero() ? std::numeric_limits<double>::infinity() : now() - stamp;
    const double time = VelocityGate::requestTime(now(), stamp);
    gate_.request(time, event.getPublisherName(), velocityOf(message.twist), age);
    publish(time);
  }

  void onUser(const geometry_msgs::Twist& message) {
    gate_.user(now(), velocityOf(message));
    publish(now());
  }

  void onEmergencyStop(const std_msgs::Bool& message) {
    gate_.emergencyStop(now(), message.data);
    publish(now());
  }

  bool onArm(ros::ServiceEvent<seater_msgs::GateArm::Request, seater_msgs::GateArm::Response>& event) {
    seater_msgs::GateArm::Response& response = event.getResponse();
    const auto refusal = gate_.arm(now(), event.getCallerName());
    response.granted = !refusal.has_value();
    if (refusal) {
      response.state = static_cast<std::uint8_t>(refusal->state);
      response.reason = refusal->reason;
    } else {
      // By the clock, so that a gate that was started anew gives no number for the second time.
      consent_ = std::max<std::uint64_t>(consent_ + 1, ros::WallTime::now().toNSec());
    }
    response.consent = consent_;
    publishState();
    return true;
  }

  // Recent requests set the pace of the output; the timer takes over when they end.
  void onTimer(const ros::TimerEvent&) {
    if (gate_.state() == GateState::kRequest && now() - last_output_ < 0.1) return;
    if (gate_.state() == GateState::kStopped && silent_) return;
    publish(now());
    silent_ = gate_.state() == GateState::kStopped;
  }

  void onStateTimer(const ros::WallTimerEvent&) {
    gate_.expire(now());
    publishState();
    updater_.update();
  }

  void publish(double now) {
    send(gate_.output(now));
    last_output_ = now;
    silent_ = false;
    if (differs(stateMessage(gate_.status(now), consent_, ros::Time()), last_state_)) publishState();
  }

  void send(const Velocity& velocity) {
    const geometry_msgs::TwistStamped stamped = commandMessage(velocity, last_stamp_);
    command_.publish(stamped.twist);
    stamped_command_.publish(stamped);
  }

  void publishState() {
    last_state_ = stateMessage(gate_.status(now()), consent_, ros::Time::now());
    state_.publish(last_state_);
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const GateState state = gate_.state();
    const bool fault = state != GateState::kStopped && state != GateState::kRequest && state != GateState::kUser;
    status.summary(fault ? DiagnosticStatus::WARN : DiagnosticStatus::OK, toString(state));
    status.add("reason", gate_.status(now()).reason);
    status.add("requests refused (not finite)", gate_.refused());
    status.add("requests ignored (no consent, stamp)", gate_.ignored());
    status.add("outputs limited", gate_.limited());
  }

  ros::NodeHandle handle_;
  VelocityGate gate_;
  ros::Publisher command_, stamped_command_, state_;
  ros::Subscriber request_, user_, emergency_stop_;
  ros::ServiceServer arm_;
  ros::Timer timer_;
  ros::WallTimer state_timer_;
  diagnostic_updater::Updater updater_;
  seater_msgs::GateState last_state_;
  std::uint64_t consent_ = 0;
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
