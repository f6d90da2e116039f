// When the gate gives consent, and when it ends.
#include "seater_safety/velocity_gate.h"
#include "words.h"

namespace seater_safety {

bool VelocityGate::insistent(double now) const {
  return now - insisted_ <= parameters_.request_timeout;
}

bool VelocityGate::holds(double now) const {
  return parameters_.hold_to_run == 0.0 || (held_ && now - held_time_ <= parameters_.user_timeout);
}

std::optional<Refusal> VelocityGate::arm(double now, const std::string& holder, bool undock) {
  notice(now);
  joystick_.update(now);
  const std::string emergency_stop = emergency(now);
  if (!emergency_stop.empty()) return Refusal{GateState::kEmergencyStop, emergency_stop};
  if (!fault_.empty()) return Refusal{fault_state_, fault_};
  if (joystick_.deflected(now)) return Refusal{GateState::kUser, "the joystick is deflected"};
  if (!holds(now)) return Refusal{GateState::kUser, "hold-to-run is not held"};
  if (charges() && !undock) return Refusal{GateState::kCharging, kInhibited};
  const std::string blind = guard_.blind(now);
  if (!blind.empty()) return Refusal{GateState::kObstacle, blind};
  if (consent_.held() && !consent_.heldBy(holder)) {
    return Refusal{GateState::kRequest, consent_.holder() + " drives"};
  }
  // Whoever went on asking for motion through a stop has not noticed it.
  if (!consent_.held() && insistent(now)) {
    return Refusal{GateState::kStopped, "velocity requests other than zero still come in"};
  }
  consent_.give(holder);
  power_cut_ = false;
  unused_.clear();
  request_ = {};
  request_seen_ = false;
  request_time_ = armed_time_ = now;
  return std::nullopt;
}

std::optional<Refusal> VelocityGate::reset(double now) {
  notice(now);
  joystick_.update(now);
  const bool due = reset_due_;
  reset_due_ = false;
  const std::string emergency_stop = emergency(now);  // but for the reset
  reset_due_ = due;
  if (!emergency_stop.empty()) return Refusal{GateState::kEmergencyStop, emergency_stop};
  if (joystick_.deflected(now)) return Refusal{GateState::kUser, "the joystick is deflected"};
  if (moving()) return Refusal{GateState::kEmergencyStop, "the chair still moves"};
  reset_due_ = false;
  return std::nullopt;
}

void VelocityGate::charging(double now, bool closed) {
  notice(now);
  expire(now);
  const bool before = inhibited();
  closed_ = closed;
  if (before || inhibited()) joystick_.lock(now);
}

// Ends the consent; what was asked for before counts no more.
void VelocityGate::stop(double now, GateState cause, const std::string& reason) {
  consent_.end(cause, reason);
  request_seen_ = false;
  request_time_ = now;
}

void VelocityGate::expire(double now) {
  const std::string blind = guard_.blind(now);
  if (!consent_.held()) return;
  if (!blind.empty()) return stop(now, GateState::kObstacle, blind);
  if (!holds(now)) return stop(now, GateState::kUser, "hold-to-run was let go");
  const double silence = now - request_time_;
  const bool idle = zero(request_) && unused_.empty();
  if (silence <= (idle ? parameters_.consent_idle_timeout : parameters_.consent_timeout)) return;
  const std::string why = unused_.empty() ? seconds("no velocity request for ", silence, "") : unused_;
  stop(now, idle ? GateState::kStopped : GateState::kStale, why);
}

}  // namespace seater_safety
