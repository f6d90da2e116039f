// What the gate says about itself.
#include "seater_safety/gate_state.h"
#include "seater_safety/velocity_gate.h"
#include "words.h"

namespace seater_safety {

std::string toString(GateState state) {
  switch (state) {
    case GateState::kStopped:
      return "stopped";
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
    case GateState::kFault:
      return "fault";
    case GateState::kRunaway:
      return "runaway, motors without power";
    case GateState::kWrongDirection:
      return "wrong direction, motors without power";
    case GateState::kObstacle:
      return "obstacle";
    case GateState::kCharging:
      return "charging";
  }
  return "unknown";
}

std::string VelocityGate::reason(double now) const {
  const std::string emergency_stop = emergency(now);
  if (!emergency_stop.empty()) return emergency_stop;
  if (!fault_.empty()) return fault_;
  if (inhibited()) return kInhibited;
  if (!guard_.reason().empty()) return guard_.reason();
  if (joystick_.drives(now)) return "the joystick drives";
  if (joystick_.deflected(now)) return "the joystick has to be let go before it drives";
  if (consent_.held()) return unused_.empty() ? consent_.holder() + " drives" : unused_;
  if (insistent(now) && !unused_.empty()) return unused_;
  if (power_cut_) return "the motors' power is cut until somebody drives anew, as they did not obey";
  return consent_.reason();
}

GateStatus VelocityGate::status(double now) const {
  GateStatus status;
  status.state = state_;
  status.stopped_by = consent_.endedBy();
  status.reason = reason(now);
  status.stop_reason = consent_.reason();
  status.motion_allowed = consent_.held();
  status.holder = consent_.holder();
  status.emergency_stop = !emergency(now).empty();
  if (request_seen_) status.request_age = now - request_time_;
  status.user_age = joystick_.age(now);
  if (pressed_seen_) status.emergency_stop_age = now - pressed_time_;
  return status;
}

}  // namespace seater_safety
