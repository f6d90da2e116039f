// Whether the chair moves as it was told to, by its odometry. No ROS.
//
// It needs no model of the motors, only bounds: a command acts after motion_delay at the latest; the chair is faster
// than it was told by motion_gain and motion_speed (motion_turning) at most; it slows down by at least half of a_max
// (alpha_max); told to go one way for a second, it does not go the other way.
#pragma once

#include <array>
#include <deque>
#include <limits>
#include <string>

#include "seater_safety/gate_parameters.h"
#include "seater_safety/gate_state.h"

namespace seater_safety {

// Without odometry for so long nothing is watched.
constexpr double kOdometryTimeout = 0.5;  // [s]
// So long the chair has to stand until a fault is over.
constexpr double kStandTime = 1.0;  // [s]

class MotionMonitor {
 public:
  // `parameters` that GateParameters::check allows.
  explicit MotionMonitor(const GateParameters& parameters);

  // What the motors are told at `now` [s] of a clock that runs forward.
  void sent(double now, const Velocity& velocity);
  // What odometry that arrives at `now` measures; not finite: not taken. True when it brings the fault.
  bool measured(double now, const Velocity& velocity);

  // Whether there is odometry to watch.
  bool watches(double now) const { return now - measured_ <= kOdometryTimeout; }
  // Empty, or what is wrong: from the time when it is noticed until the chair has stood for kStandTime.
  const std::string& fault() const { return fault_; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  struct Sent {
    double time;
    Velocity velocity;
  };
  struct Range {
    double least, most;
  };
  struct Axis {
    double Velocity::*of;
    const char* moves;
    const char* unit;
    double margin;                 // beyond gain times what was sent
    double braking;                // [m/s^2], [rad/s^2] at least
    double wrong_way;              // slower than this, or told less than this, is no motion the wrong way
    double bound = kNever;         // what was sent explains speeds up to this
    double beyond_since = kNever;  // [s]
    double wrong_since = kNever;
  };

  void forget();
  std::string judge(Axis& axis, double now, double elapsed, double speed);
  Range sentWithin(double now, double duration, double Velocity::*of) const;
  bool lasts(double& since, double now, bool wrong) const;
  void clearWhenStanding(double now, const Velocity& velocity);

  double delay_, gain_, time_;
  std::array<Axis, 2> axes_;
  std::deque<Sent> sent_;  // of the last seconds, and the one before
  double measured_ = -kNever;
  double stands_since_ = kNever;
  std::string fault_;
};

}  // namespace seater_safety
