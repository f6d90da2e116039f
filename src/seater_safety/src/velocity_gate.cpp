#include "seater_safety/velocity_gate.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace seater_safety {
namespace {

// Longest time for which the speed may change in one call: a pause must not become a jump of speed.
constexpr double kLongestStep = 0.1;  // [s]

bool finite(const Velocity& velocity) {
  return std::isfinite(velocity.linear) && std::isfinite(velocity.angular);
}

bool zero(const Velocity& velocity) {
  return velocity.linear == 0.0 && velocity.angular == 0.0;
}

// One step from `last` towards `wanted`, of at most `faster` away from zero or `slower` towards it.
double approach(double last, double wanted, double faster, double slower) {
  // Crossing zero stops at zero first: beyond it the other limit applies.
  if (last > 0.0 && wanted < 0.0) return std::max(0.0, last - slower);
  if (last < 0.0 && wanted > 0.0) return std::min(0.0, last + slower);
  const double step = std::abs(wanted) > std::abs(last) ? faster : slower;
  return std::clamp(wanted, last - step, last + step);
}

std::string seconds(const std::string& before, double value, const std::string& after) {
  std::ostringstream text;
  text.precision(2);
  text << before << std::fixed << value << " s" << after;
  return text.str();
}

}  // namespace

VelocityGate::VelocityGate(const GateParameters& parameters) : parameters_(parameters), joystick_(parameters, 0.0) {
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
  insisted_ = -1e9;
  last_time_ = now;
  started_ = true;
}

// Ends the consent; what was asked for before counts no more.
void VelocityGate::stop(double now, GateState cause, const std::string& reason) {
  consent_.end(cause, reason);
  request_seen_ = false;
  request_time_ = now;
}

bool VelocityGate::insistent(double now) const {
  return now - insisted_ <= parameters_.request_timeout;
}

std::optional<Refusal> VelocityGate::arm(double now, const std::string& holder) {
  notice(now);
  joystick_.update(now);
  if (emergency_stop_) return Refusal{GateState::kEmergencyStop, "the emergency stop is pressed"};
  if (!fault_.empty()) return Refusal{GateState::kFault, fault_};
  if (joystick_.deflected(now)) return Refusal{GateState::kUser, "the joystick is deflected"};
  if (consent_.held() && !consent_.heldBy(holder)) {
    return Refusal{GateState::kRequest, consent_.holder() + " drives"};
  }
  // Whoever went on asking for motion through a stop has not noticed it.
  if (!consent_.held() && insistent(now)) {
    return Refusal{GateState::kStopped, "velocity requests other than zero still come in"};
  }
  consent_.give(holder);
  unused_.clear();
  request_ = {};
  request_seen_ = false;
  request_time_ = now;
  return std::nullopt;
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

void VelocityGate::emergencyStop(double now, bool pressed) {
  notice(now);
  emergency_stop_ = pressed;
  emergency_stop_time_ = now;
  if (!pressed) return;
  stop(now, GateState::kEmergencyStop, "the emergency stop was pressed");
  joystick_.lock(now);
}

void VelocityGate::fault(double now, const std::string& reason) {
  notice(now);
  fault_ = reason;
  if (reason.empty()) return;
  stop(now, GateState::kFault, reason);
  joystick_.lock(now);
}

Velocity VelocityGate::wanted(double now) {
  joystick_.update(now);
  if (emergency_stop_) {
    state_ = GateState::kEmergencyStop;
    joystick_.lock(now);
    return {};
  }
  if (!fault_.empty()) {
    state_ = GateState::kFault;
    joystick_.lock(now);
    return {};
  }
  if (joystick_.drives(now)) {
    state_ = GateState::kUser;
    return joystick_.velocity();
  }
  return requested(now);
}

void VelocityGate::expire(double now) {
  if (!consent_.held()) return;
  const double silence = now - request_time_;
  const bool idle = zero(request_) && unused_.empty();
  if (silence <= (idle ? parameters_.consent_idle_timeout : parameters_.consent_timeout)) return;
  const std::string why = unused_.empty() ? seconds("no velocity request for ", silence, "") : unused_;
  stop(now, idle ? GateState::kStopped : GateState::kStale, why);
}

Velocity VelocityGate::requested(double now) {
  expire(now);
  if (!consent_.held()) {
    const bool refused = moving() && consent_.endedBy() == GateState::kRefused;
    state_ = refused ? GateState::kRefused : GateState::kStopped;
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
  const Velocity bounded{std::clamp(asked.linear, -p.v_reverse_max, p.v_max),
                         std::clamp(asked.angular, -p.omega_max, p.omega_max)};
  if (bounded.linear != asked.linear || bounded.angular != asked.angular) ++limited_;

  // A late clock gives no time to change the speed in.
  const double step = std::clamp(now - last_time_, 0.0, kLongestStep);
  last_.linear = approach(last_.linear, bounded.linear, p.a_max * step, p.a_stop * step);
  last_.angular = approach(last_.angular, bounded.angular, p.alpha_max * step, p.alpha_stop * step);
  last_time_ = std::max(last_time_, now);
  return last_;
}

}  // namespace seater_safety
