#include "seater_safety/velocity_gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace seater_safety {
namespace {

// Longest time for which the speed may change in one call: a pause must not become a jump of speed.
constexpr double kLongestStep = 0.1;  // [s]

// A smaller step backward of the clock is lateness of a message, not a jump.
constexpr double kLateness = 0.25;  // [s]

bool finite(const Velocity& velocity) {
  return std::isfinite(velocity.linear) && std::isfinite(velocity.angular);
}

// One step from `last` towards `wanted`, of at most `faster` away from zero or `slower` towards it.
double approach(double last, double wanted, double faster, double slower) {
  // Crossing zero stops at zero first: beyond it the other limit applies.
  if (last > 0.0 && wanted < 0.0) return std::max(0.0, last - slower);
  if (last < 0.0 && wanted > 0.0) return std::min(0.0, last + slower);
  const double step = std::abs(wanted) > std::abs(last) ? faster : slower;
  return std::clamp(wanted, last - step, last + step);
}

}  // namespace

std::string GateParameters::check() const {
  const std::array<std::pair<const char*, double>, 9> values = {{{"v_max", v_max},
                                                                 {"v_reverse_max", v_reverse_max},
                                                                 {"omega_max", omega_max},
                                                                 {"a_max", a_max},
                                                                 {"alpha_max", alpha_max},
                                                                 {"a_stop", a_stop},
                                                                 {"alpha_stop", alpha_stop},
                                                                 {"request_timeout", request_timeout},
                                                                 {"user_timeout", user_timeout}}};
  for (const auto& [name, value] : values) {
    if (std::isfinite(value) && value > 0.0) continue;
    std::ostringstream text;
    text << name << ": is " << value << ", must be finite and > 0";
    return text.str();
  }
  return {};
}

std::string toString(GateState state) {
  switch (state) {
    case GateState::kStopped:
      return "stopped, nobody asks";
    case GateState::kRequest:
      return "docking controller";
    case GateState::kUser:
      return "joystick";
    case GateState::kStale:
      return "request too old, stopping";
    case GateState::kRefused:
      return "request not finite, stopping";
    case GateState::kEmergencyStop:
      return "emergency stop";
  }
  return "unknown";
}

VelocityGate::VelocityGate(const GateParameters& parameters) : parameters_(parameters) {
  const std::string problem = parameters.check();
  if (!problem.empty()) throw std::invalid_argument(problem);
}

void VelocityGate::store(Source& source, double now, const Velocity& velocity) {
  source.refused = !finite(velocity);
  if (source.refused) ++refused_;
  source.velocity = source.refused ? Velocity{} : velocity;
  source.time = now;
  source.seen = true;
}

double VelocityGate::requestTime(double now, double stamp) {
  return stamp > now && stamp <= now + kLateness ? stamp : now;
}

void VelocityGate::request(double now, const Velocity& velocity) {
  store(request_, now, velocity);
}

void VelocityGate::user(double now, const Velocity& velocity) {
  store(user_, now, velocity);
}

bool VelocityGate::fresh(const Source& source, double now, double timeout) {
  return source.seen && now - source.time <= timeout;
}

Velocity VelocityGate::wanted(double now) {
  if (emergency_stop_) {
    state_ = GateState::kEmergencyStop;
    return {};
  }
  if (fresh(user_, now, parameters_.user_timeout)) {
    state_ = user_.refused ? GateState::kRefused : GateState::kUser;
    return user_.velocity;
  }
  if (fresh(request_, now, parameters_.request_timeout)) {
    state_ = request_.refused ? GateState::kRefused : GateState::kRequest;
    return request_.velocity;
  }
  const bool moving = last_.linear != 0.0 || last_.angular != 0.0;
  state_ = moving ? GateState::kStale : GateState::kStopped;
  return {};
}

void VelocityGate::noticeTimeJump(double now) {
  if (!started_ || now >= last_time_ - kLateness) return;
  // Sources of the time before the jump would stay fresh until the clock is back there. One that was stored just now
  // is older than nothing, and stays.
  for (Source* source : {&request_, &user_}) {
    if (source->time > now) source->seen = false;
  }
  last_time_ = now;
}

Velocity VelocityGate::output(double now) {
  noticeTimeJump(now);
  const Velocity asked = wanted(now);
  const GateParameters& p = parameters_;
  const Velocity bounded{std::clamp(asked.linear, -p.v_reverse_max, p.v_max),
                         std::clamp(asked.angular, -p.omega_max, p.omega_max)};
  if (bounded.linear != asked.linear || bounded.angular != asked.angular) ++limited_;

  // A late clock gives no time to change the speed in.
  const double step = started_ ? std::clamp(now - last_time_, 0.0, kLongestStep) : kLongestStep;
  last_.linear = approach(last_.linear, bounded.linear, p.a_max * step, p.a_stop * step);
  last_.angular = approach(last_.angular, bounded.angular, p.alpha_max * step, p.alpha_stop * step);
  last_time_ = std::max(last_time_, now);
  started_ = true;
  return last_;
}

}  // namespace seater_safety
