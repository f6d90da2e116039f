// The last gate before the motors, free of ROS.
//
// Whatever comes in, what goes out is finite, within the limits of speed and acceleration, and zero when nobody who is
// allowed to ask has asked recently. Times are seconds of one clock; where it jumps backward, all that was asked for
// before is forgotten. Speeds are m/s and rad/s in base_link (x forward, anticlockwise positive).
#pragma once

#include <string>

namespace seater_safety {

struct Velocity {
  double linear = 0.0;   // [m/s] forward
  double angular = 0.0;  // [rad/s] anticlockwise
};

// What the gate lets through. Every value is positive and finite; `check` says what is wrong otherwise.
struct GateParameters {
  double v_max = 0.6;             // [m/s] forward
  double v_reverse_max = 0.3;     // [m/s] backward
  double omega_max = 0.8;         // [rad/s] both ways
  double a_max = 0.5;             // [m/s^2] speeding up
  double alpha_max = 1.0;         // [rad/s^2] turning faster
  double a_stop = 1.5;            // [m/s^2] slowing down; larger than a_max, so that a stop is never delayed by comfort
  double alpha_stop = 3.0;        // [rad/s^2] slowing the turn down
  double request_timeout = 0.25;  // [s] an older request counts as none
  double user_timeout = 0.5;      // [s] the joystick rules this long after it was last moved

  // Empty when all is well, else the name of the first wrong value, what it is and what is allowed.
  std::string check() const;
};

enum class GateState { kStopped, kRequest, kUser, kStale, kRefused, kEmergencyStop };

std::string toString(GateState state);

class VelocityGate {
 public:
  // Throws std::invalid_argument with the text of GateParameters::check.
  explicit VelocityGate(const GateParameters& parameters);

  // The time [s] at which a request counts as made: `now`, or its stamp where that is a little later. Simulated time
  // and a request stamped with it come on two connections, and which is read first is up to the machine; with the stamp
  // the gate does the same either way. A stamp far in the future is not believed.
  static double requestTime(double now, double stamp);

  // The docking controller asks. A request that is not finite is refused: it counts as a request for zero.
  void request(double now, const Velocity& velocity);
  // The person in the seat moves the joystick: this has precedence while it is fresh. Not finite: refused, as above.
  void user(double now, const Velocity& velocity);
  // While pressed, zero is asked for, whatever else comes in.
  void emergencyStop(bool pressed) { emergency_stop_ = pressed; }

  // What goes to the motors now. To be called after each request and, when none comes, at a steady rate.
  Velocity output(double now);

  GateState state() const { return state_; }
  // Requests that were not finite, since the start.
  unsigned refused() const { return refused_; }
  // Outputs that differ from what was asked for because of a limit of speed, since the start.
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
