// What the velocity gate does, and why. The numbers of seater_msgs/GateState.
#pragma once

#include <cstdint>
#include <string>

namespace seater_safety {

enum class GateState : std::uint8_t {
  kStopped = 0,        // nobody asks, or nobody may
  kRequest = 1,        // requests of the holder of the consent pass
  kUser = 2,           // the joystick drives
  kStale = 3,          // the holder of the consent is silent: braking
  kRefused = 4,        // a request was not finite: braking
  kEmergencyStop = 5,  // pressed
  kFault = 6,          // something round the gate is wrong, see the reason
  // The motors do not obey, and have no power:
  kRunaway = 7,         // faster than told
  kWrongDirection = 8,  // the other way than told
  kObstacle = 9,        // something is in the way, or a sensor of obstacles is silent: zero, with power
  kCharging = 10,       // the charging contact is closed: nothing moves until a goal undocks
};

std::string toString(GateState state);

struct Velocity {
  double linear = 0.0;   // [m/s] forward
  double angular = 0.0;  // [rad/s] anticlockwise
};

// The gate for people and for the one who drives. Ages in seconds; -1: never.
struct GateStatus {
  GateState state = GateState::kStopped;
  GateState stopped_by = GateState::kStopped;  // what ended the last consent; kStopped: it ended by itself, or none did
  std::string reason;                          // of the state
  std::string stop_reason;                     // of the end of the last consent; empty: it is held
  bool motion_allowed = false;                 // a consent is held: requests of its holder pass
  std::string holder;                          // of the last consent
  bool emergency_stop = false;                 // pressed, silent for too long, or not reset
  double request_age = -1.0;                   // since the last request that was accepted
  double user_age = -1.0;
  double emergency_stop_age = -1.0;
};

}  // namespace seater_safety
