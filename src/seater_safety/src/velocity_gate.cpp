#include "seater_safety/velocity_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "words.h"

namespace seater_safety {
namespace {

// Longest time for which the speed may change in one call: a pause must not become a jump of speed.
constexpr double kLongestStep = 0.1;  // [s]
// Silence of cmd_vel after which a base stops by itself (docs/safety.md, base driver).
constexpr double kSilence = 0.3;  // [s]

constexpr double kNever = std::numeric_limits<double>::infinity();

bool finite(const Velocity& velocity) {
  return std::isfinite(velocity.linear) && std::isfinite(velocity.angular);
}

}  // namespace

VelocityGate::VelocityGate(const GateParameters& parameters, const std::vector<std::string>& required)
    : parameters_(parameters),
      joystick_(parameters, 0.0),
      guard_(parameters, required),
      linear_({parameters.a_max, parameters.a_stop, parameters.jerk_max}),
      angular_({parameters.alpha_max, parameters.alpha_stop, parameters.angular_jerk_max}) {
  const std::string problem = parameters.check();
  if (!problem.empty()) throw std::invalid_argument(problem);
}

double VelocityGate::requestTime(double now, double stamp) {
  return stamp > now && stamp <= now + kLateness ? stamp : now;
}

void VelocityGate::notice(double now) {
  if (started_ && now >= last_time_ - kLateness) return;
  if (started_) stop(now, GateState::kFault, "the clock jumped backward");
  // What was stored before the jump would stay fresh until the clock is back there.
  joystick_ = Joystick(parameters_, now);
  zone_.forget();
  guard_.forget();
  held_ = false;
  insisted_ = -1e9;
  pressed_time_ = now;
  last_time_ = now;
  started_ = true;
}

void VelocityGate::request(double now, const std::string& sender, const Velocity& velocity, double age) {
  notice(now);
  if (!zero(velocity)) insisted_ = now;
  if (!finite(velocity)) {
    ++refused_;
    stop(now, GateState::kRefused, "a velocity request of " + sender + " was not finite");
    return;
  }
  unused_.clear();
  if (consent_.held() && !consent_.heldBy(sender)) {
    unused_ = sender + " sends velocity requests, though " + consent_.holder() + " drives";
    stop(now, GateState::kFault, unused_);
  } else if (!consent_.held()) {
    unused_ = zero(velocity) ? "" : sender + " sends velocity requests without consent";
  } else if (std::isinf(age)) {
    unused_ = "the velocity requests have no stamp";
  } else if (!(age <= parameters_.request_max_age)) {
    unused_ = seconds("the stamp of the velocity requests is ", age, " old");
  } else if (!(age >= -kLateness)) {
    unused_ = seconds("the stamp of the velocity requests is ", -age, " in the future");
  } else {
    request_ = velocity;
    request_time_ = now;
    request_seen_ = true;
    return;
  }
  ++ignored_;
}

void VelocityGate::user(double now, const Velocity& velocity) {
  notice(now);
  const bool usable = finite(velocity);
  if (!usable) {
    ++refused_;
    stop(now, GateState::kRefused, "a joystick command was not finite");
  }
  joystick_.command(now, usable ? velocity : Velocity{});
  if (joystick_.deflected(now)) stop(now, GateState::kUser, "the joystick was moved");
}

void VelocityGate::holdToRun(double now, bool held) {
  notice(now);
  held_ = held;
  held_time_ = now;
  expire(now);
}

void VelocityGate::emergencyStop(double now, bool pressed) {
  notice(now);
  pressed_ = pressed;
  pressed_time_ = now;
  pressed_seen_ = true;
  if (pressed) latchEmergencyStop(now, "the emergency stop was pressed");
}

void VelocityGate::latchEmergencyStop(double now, const std::string& reason) {
  reset_due_ = parameters_.emergency_stop_reset != 0.0;
  stop(now, GateState::kEmergencyStop, reason);
  joystick_.lock(now);
}

std::string VelocityGate::emergency(double now) const {
  if (pressed_) return "the emergency stop is pressed";
  const double timeout = parameters_.emergency_stop_timeout;
  const bool silent = timeout > 0.0 && (!pressed_seen_ || now - pressed_time_ > timeout);
  if (silent) return "the emergency stop is silent, which counts as pressed";
  return reset_due_ ? "the emergency stop was released, but not reset (gate_reset)" : "";
}

void VelocityGate::speedLimit(double from, double limit) {
  if (!zone_.told(from, limit)) ++refused_;
}

void VelocityGate::obstacles(double from, double measured, const std::string& source, std::vector<Point> points,
                             const std::string& blocked) {
  guard_.seen(from, measured, source, std::move(points), blocked);
}

void VelocityGate::fault(double now, const std::string& reason, GateState cause) {
  notice(now);
  fault_ = reason;
  fault_state_ = cause;
  if (reason.empty()) return;
  stop(now, cause, reason);
  joystick_.lock(now);
}

void VelocityGate::cutPower(double now, GateState cause, const std::string& reason) {
  fault(now, reason, cause);
  linear_.drop();
  angular_.drop();
  power_cut_ = true;
}

Velocity VelocityGate::wanted(double now) {
  joystick_.update(now);
  const std::string emergency = this->emergency(now);
  if (!emergency.empty()) {
    state_ = GateState::kEmergencyStop;
    latchEmergencyStop(now, emergency);
    return {};
  }
  if (!fault_.empty()) {
    state_ = fault_state_;
    joystick_.lock(now);
    return {};
  }
  if (inhibited()) {
    state_ = GateState::kCharging;
    joystick_.lock(now);
    return {};
  }
  if (joystick_.drives(now)) {
    state_ = GateState::kUser;
    power_cut_ = false;
    return joystick_.velocity();
  }
  return requested(now);
}

Velocity VelocityGate::requested(double now) {
  expire(now);
  if (!consent_.held()) {
    const bool refused = moving() && consent_.endedBy() == GateState::kRefused;
    const bool unseen = consent_.endedBy() == GateState::kObstacle && !guard_.blind(now).empty();
    state_ = refused ? GateState::kRefused : unseen ? GateState::kObstacle : GateState::kStopped;
    return {};
  }
  if (request_seen_ && now - request_time_ <= parameters_.request_timeout) {
    state_ = GateState::kRequest;
    return request_;
  }
  state_ = moving() ? GateState::kStale : GateState::kStopped;
  return {};
}

Velocity VelocityGate::output(double now) {
  notice(now);
  const Velocity asked = wanted(now);
  const GateParameters& p = parameters_;
  const bool silent = now - last_time_ > kSilence;  // this process stood still; what it sent last is over
  if (silent) {
    linear_.drop();
    angular_.drop();
  }
  // A late clock gives no time to change the speed in.
  const double step = silent ? 0.0 : std::clamp(now - last_time_, 0.0, kLongestStep);
  const double zone = zone_.limit(now, linear_.speed(), p.a_max * step, consent_.held() ? armed_time_ : kNever);
  const Velocity bounded{std::clamp(asked.linear, -std::min(zone, p.v_reverse_max), std::min(zone, p.v_max)),
                         std::clamp(asked.angular, -p.omega_max, p.omega_max)};
  if (bounded.linear != asked.linear || bounded.angular != asked.angular) ++limited_;
  last_time_ = std::max(last_time_, now);
  const Velocity free = kept(now, bounded);
  const Velocity output{linear_.advance(free.linear, step), angular_.advance(free.angular, step)};
  guard_.sent(now, output);
  return output;
}

// Clear of obstacles.
Velocity VelocityGate::kept(double now, const Velocity& bounded) {
  const bool watched = state_ != GateState::kUser || parameters_.obstacle_joystick != 0.0;
  const Velocity free = guard_.limited(now, watched ? bounded : Velocity{});
  if (!watched) return bounded;
  if (free.linear != bounded.linear || free.angular != bounded.angular) ++limited_;
  if (zero(free) && !zero(bounded)) state_ = GateState::kObstacle;
  return free;
}

}  // namespace seater_safety
