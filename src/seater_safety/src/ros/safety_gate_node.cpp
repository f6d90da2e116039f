#include "safety_gate_node.h"

#include <algorithm>
#include <string>
#include <utility>

namespace seater_safety {
namespace {

constexpr double kPeriod = 0.02;             // [s] of the output
constexpr double kSupervisionPeriod = 0.05;  // [s] of motor_enable
constexpr unsigned kStateEvery = 2;          // supervisions: gate_state at 10 Hz
constexpr double kZoneDelay = 0.2;           // [s] of simulated time: four control cycles
constexpr double kSightDelay = 0.25;         // [s] the same of a measurement, which is delivered a little later
constexpr double kLongestBraking = 1.5;      // [s] before the node ends

constexpr const char* kBaseFrame = "base_link";

Velocity velocityOf(const geometry_msgs::Twist& message) {
  return {message.linear.x, message.angular.z};
}

}  // namespace

SafetyGateNode::SafetyGateNode(const GateParameters& parameters, const std::vector<std::string>& sources,
                               bool lock_step)
    : clocks_(lock_step), gate_(parameters, sources), motion_(parameters), out_(handle_), neighbours_(handle_) {
  const ros::TransportHints prompt = ros::TransportHints().tcpNoDelay();
  request_ = handle_.subscribe("velocity_request", 10, &SafetyGateNode::onRequest, this, prompt);
  user_ = handle_.subscribe("user_cmd_vel", 1, &SafetyGateNode::onUser, this, prompt);
  emergency_stop_ = handle_.subscribe("emergency_stop", 10, &SafetyGateNode::onEmergencyStop, this, prompt);
  speed_limit_ = handle_.subscribe("speed_limit", 10, &SafetyGateNode::onSpeedLimit, this, prompt);
  hold_ = handle_.subscribe("hold_to_run", 10, &SafetyGateNode::onHold, this, prompt);
  if (parameters.charging_inhibit != 0.0) {
    contact_ = handle_.subscribe("charging_contact", 10, &SafetyGateNode::onContact, this, prompt);
    neighbours_.watch(contact_);
  }
  for (const ros::Subscriber& input : {request_, user_, emergency_stop_, speed_limit_, hold_}) neighbours_.watch(input);
  obstacles_ = handle_.subscribe("obstacle_points", 10, &SafetyGateNode::onObstacles, this, prompt);
  neighbours_.watch(obstacles_, std::max<std::size_t>(1, sources.size()));
  // Told while a person drives: a docking keeps clear of the walls by itself, nearer than the margin.
  walls_ = handle_.subscribe("bay_walls", 10, &SafetyGateNode::onObstacles, this, prompt);
  neighbours_.watch(walls_);
  arm_ = handle_.advertiseService("gate_arm", &SafetyGateNode::onArm, this);
  reset_ = handle_.advertiseService("gate_reset", &SafetyGateNode::onReset, this);
  if (lock_step) {
    lock_step_timer_ = handle_.createTimer(ros::Duration(kPeriod), &SafetyGateNode::onLockStepTimer, this);
  } else {
    timer_ = handle_.createSteadyTimer(ros::WallDuration(kPeriod), &SafetyGateNode::onTimer, this);
    odometry_ = handle_.subscribe("odom", 10, &SafetyGateNode::onOdometry, this, prompt);
    neighbours_.watch(odometry_);
    motor_fault_ = handle_.subscribe("motor_fault", 10, &SafetyGateNode::onMotorFault, this, prompt);
    master_ = std::make_unique<MasterLink>();
    if (MasterLink::wasPressed()) gate_.emergencyStop(clocks_.now(), true);
  }
  const ros::WallDuration period(kSupervisionPeriod);
  supervision_ = handle_.createSteadyTimer(period, &SafetyGateNode::onSupervision, this);
  updater_.setHardwareID("seater_safety");
  updater_.add("gate", this, &SafetyGateNode::diagnose);
}

void SafetyGateNode::stop() {
  gate_.fault(clocks_.now(), "the safety gate ends");
  out_.state(gate_.status(clocks_.now()), consent_);
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(kLongestBraking);
  while (!clocks_.lockStep() && gate_.motorsEnabled(clocks_.now()) && ros::SteadyTime::now() < end) {
    send(clocks_.now());
    ros::WallDuration(kPeriod).sleep();
  }
  out_.command(Velocity{}, last_stamp_);
  out_.enable(false);
}

void SafetyGateNode::onRequest(const ros::MessageEvent<geometry_msgs::TwistStamped const>& event) {
  const geometry_msgs::TwistStamped& message = *event.getConstMessage();
  last_stamp_ = message.header.stamp;
  double now = clocks_.now();
  if (clocks_.lockStep()) now = VelocityGate::requestTime(now, last_stamp_.toSec());
  gate_.request(now, event.getPublisherName(), velocityOf(message.twist), Clocks::age(last_stamp_));
  send(now);
}

void SafetyGateNode::onUser(const geometry_msgs::Twist& message) {
  gate_.user(clocks_.now(), velocityOf(message));
  send(clocks_.now());
}

void SafetyGateNode::onEmergencyStop(const std_msgs::Bool& message) {
  gate_.emergencyStop(clocks_.now(), message.data != 0);
  if (master_ != nullptr) master_->remember(message.data != 0);
  send(clocks_.now());
}

void SafetyGateNode::onHold(const std_msgs::Bool& message) {
  gate_.holdToRun(clocks_.now(), message.data != 0);
}

void SafetyGateNode::onContact(const std_msgs::Bool& message) {
  gate_.charging(clocks_.now(), message.data != 0);
}

// In lock-step it counts from a time that is still to come, so that it does not matter whether it is read before or
// after the request that was sent next.
void SafetyGateNode::onSpeedLimit(const seater_msgs::SpeedLimit& message) {
  const double from = clocks_.lockStep() ? message.header.stamp.toSec() + kZoneDelay : clocks_.now();
  gate_.speedLimit(from, message.v_max);
}

// In lock-step as the speed limit. Another frame than the chair's counts as blocked: nobody knows where the points are.
void SafetyGateNode::onObstacles(const seater_msgs::ObstaclePoints& message) {
  const double now = clocks_.now(), stamp = message.header.stamp.toSec();
  const double from = clocks_.lockStep() ? stamp + kSightDelay : now;
  const double measured = clocks_.lockStep() ? stamp : now - Clocks::age(message.header.stamp);
  std::string blocked = message.blocked;
  if (message.header.frame_id != kBaseFrame) blocked = "its points are in the frame '" + message.header.frame_id + "'";
  if (message.x.size() != message.y.size()) blocked = "its points have not as many x as y";
  std::vector<Point> points;
  for (std::size_t i = 0; blocked.empty() && i < message.x.size(); ++i) points.push_back({message.x[i], message.y[i]});
  gate_.obstacles(from, measured, message.source, std::move(points), blocked);
}

// Motors that do not obey are told to brake in vain: they lose their power at once.
void SafetyGateNode::onOdometry(const nav_msgs::Odometry& message) {
  if (motion_.measured(clocks_.now(), velocityOf(message.twist.twist))) cutPower();
}

void SafetyGateNode::onMotorFault(const seater_msgs::MotorFault& message) {
  const bool wrong = message.state == seater_msgs::GateState::WRONG_DIRECTION;
  const GateState cause = wrong ? GateState::kWrongDirection : GateState::kRunaway;
  if (motion_.told({cause, message.reason})) cutPower();
}

void SafetyGateNode::cutPower() {
  const double now = clocks_.now();
  gate_.cutPower(now, motion_.fault().cause, motion_.fault().reason);
  out_.enable(false);
  send(now);
}

bool SafetyGateNode::onArm(ArmEvent& event) {
  seater_msgs::GateArm::Response& response = event.getResponse();
  noticeFaults();
  const auto refusal = gate_.arm(clocks_.now(), event.getCallerName(), event.getRequest().undock != 0);
  response.granted = static_cast<std::uint8_t>(!refusal.has_value());
  if (refusal) {
    response.state = static_cast<std::uint8_t>(refusal->state);
    response.reason = refusal->reason;
  } else {
    // By the clock, so that a gate that was started anew gives no number for the second time.
    consent_ = std::max<std::uint64_t>(consent_ + 1, ros::WallTime::now().toNSec());
  }
  response.consent = consent_;
  out_.state(gate_.status(clocks_.now()), consent_);
  return true;
}

bool SafetyGateNode::onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const auto refusal = gate_.reset(clocks_.now());
  response.success = static_cast<std::uint8_t>(!refusal.has_value());
  response.message = refusal ? refusal->reason : "";
  return true;
}

// Recent requests set the pace of the output; the timer takes over when they end. One that came at any time would
// change the ramp between two requests, and with it the run.
void SafetyGateNode::onLockStepTimer(const ros::TimerEvent&) {
  const double now = clocks_.now();
  const bool requested = gate_.state() == GateState::kRequest || gate_.state() == GateState::kObstacle;
  if (requested && now - last_output_ < 0.1) return;
  const auto stands = [this] { return gate_.state() == GateState::kStopped || gate_.state() == GateState::kCharging; };
  if (stands() && silent_) return;
  send(now);
  silent_ = stands();
}

void SafetyGateNode::onSupervision(const ros::SteadyTimerEvent&) {
  const double now = clocks_.now();
  noticeFaults();
  gate_.expire(now);
  out_.enable(gate_.motorsEnabled(clocks_.now()));
  const GateStatus status = gate_.status(now);
  if (supervisions_++ % kStateEvery == 0) out_.state(status, consent_);
  out_.stateIfChanged(status, consent_);
  updater_.update();
}

void SafetyGateNode::send(double now) {
  const Velocity velocity = gate_.output(now);
  motion_.sent(now, velocity);
  out_.command(velocity, last_stamp_);
  out_.stateIfChanged(gate_.status(now), consent_);
  last_output_ = now;
  silent_ = false;
}

// The first of what is wrong round the gate.
void SafetyGateNode::noticeFaults() {
  const MotionFault& motion = motion_.fault();
  const bool obeys = motion.reason.empty();
  gate_.fault(clocks_.now(), obeys ? surroundings() : motion.reason, obeys ? GateState::kFault : motion.cause);
}

std::string SafetyGateNode::surroundings() {
  const std::string clock = clocks_.check();
  if (!clock.empty()) return clock;
  const std::string neighbours = neighbours_.check();
  if (!neighbours.empty() || master_ == nullptr) return neighbours;
  return master_->check();
}

void SafetyGateNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const GateState state = gate_.state();
  const bool fault = state != GateState::kStopped && state != GateState::kRequest && state != GateState::kUser &&
                     state != GateState::kCharging;
  const std::string reason = gate_.status(clocks_.now()).reason;
  const std::string text = toString(state) + (reason.empty() ? "" : ": " + reason);
  const char* remedy = " (what to do: docs/safety.md#state-of-the-gate)";
  status.summary(fault ? DiagnosticStatus::WARN : DiagnosticStatus::OK, fault ? text + remedy : text);
  status.add("reason", reason);
  const bool watched = motion_.watches(clocks_.now());
  status.add("motion monitor", watched ? "on" : clocks_.lockStep() ? "off in lock-step" : "off: no odometry");
  status.add("requests refused (not finite)", gate_.refused());
  status.add("requests ignored (no consent, stamp)", gate_.ignored());
  status.add("outputs limited", gate_.limited());
}

}  // namespace seater_safety
