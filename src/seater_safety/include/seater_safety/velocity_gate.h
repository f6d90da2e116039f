// The last gate before the motors, without ROS.
//
// The output is always finite and within the limits of speed and acceleration. It goes to zero when there is no recent
// request from the docking controller or the joystick. Times are seconds of one clock; a jump backward discards all
// earlier requests. Speeds are m/s and rad/s in base_link (x forward, anticlockwise positive).
#pragma once

#include <string>

namespace seater_safety {

struct Velocity {
  double linear = 0.0;   // [m/s] forward
  double angular = 0.0;  // [rad/s] anticlockwise
};

// Limits and time-outs of the gate. Every value must be positive and finite (see `check`).
struct GateParameters {
  double v_max = 0.6;             // [m/s] forward
  double v_reverse_max = 0.3;     // [m/s] backward
  double omega_max = 0.8;         // [rad/s] both ways
  double a_max = 0.5;             // [m/s^2] speeding up
  double alpha_max = 1.0;         // [rad/s^2] turning faster
  double a_stop = 1.5;            // [m/s^2] slowing down; larger than a_max: a stop may be harder than comfortable
  double alpha_stop = 3.0;        // [rad/s^2] slowing the turn down
  double request_timeout = 0.25;  // [s] an older request is ignored
  double user_timeout = 0.5;      // [s] the joystick has precedence for this long after its last command

  // Empty when all values are valid, else name and value of the first wrong one and what is allowed.
  std::string check() const;
};

enum class GateState { kStopped, kRequest, kUser, kStale, kRefused, kEmergencyStop };

std::string toString(GateState state);

class VelocityGate {
 public:
  // Throws std::invalid_argument with the text of GateParameters::check.
  explicit VelocityGate(const GateParameters& parameters);

  // The time [s] of a request: `now`, or its stamp where that is a little later. Simulated time and a request stamped
  // with it arrive on two connections in either order; with the stamp the output does not depend on the order. A stamp
  // far in the future is ignored.
  static double requestTime(double now, double stamp);

  // A request of the docking controller. One that is not finite is refused and counts as a request for zero.
  void request(double now, const Velocity& velocity);
  // A joystick command of the person in the seat; it has precedence while it is recent. Not finite: refused, as above.
  void user(double now, const Velocity& velocity);
  // While pressed, the requested velocity is zero.
  void emergencyStop(bool pressed) { emergency_stop_ = pressed; }

  // The velocity for the motors at `now` [s]. To be called after each request and at a steady rate without requests.
  Velocity output(double now);

  GateState state() const { return state_; }
  // Requests that were not finite, since the start.
  unsigned refused() const { return refused_; }
  // Outputs that differ from the request because of a speed limit, since the start.
  unsigned limited() const { return limited_; }

 private:
  struct Source {
    Velocity velocity;
    double time = 0.0;
    bool seen = false;
    bool refused = false;
  };

  void store(Source& source, double now, const Velocity& velocity);
  void noticeTimeJump(double now);
  static bool fresh(const Source& source, double now, double timeout);
  Velocity wanted(double now);

  GateParameters parameters_;
  Source request_;
  Source user_;
  bool emergency_stop_ = false;
  Velocity last_;
  double last_time_ = 0.0;
  bool started_ = false;
  GateState state_ = GateState::kStopped;
  unsigned refused_ = 0;
  unsigned limited_ = 0;
};

}  // namespace seater_safety
