// Whether the chair moves as it was told to, by its odometry. No ROS.
//
// It needs no model of the motors, only bounds: a command acts after motion_delay at the latest; the chair is faster
// than it was told by motion_gain and motion_speed (motion_turning) at most; it slows down by at least half of a_max
// (alpha_max), and by at least a third of what it is told to; told to go one way for a second, it does not go the other
// way; both of its motors turn.
#pragma once

#include <array>
#include <limits>
#include <string>

#include "seater_safety/gate_parameters.h"
#include "seater_safety/gate_state.h"
#include "seater_safety/speed_history.h"

namespace seater_safety {

// Without odometry for so long nothing is watched.
constexpr double kOdometryTimeout = 0.5;  // [s]
// So long the chair has to stand until a fault is over.
constexpr double kStandTime = 1.0;  // [s]

// How the motors disobey. `cause`: kRunaway or kWrongDirection; `reason` in words; empty: they obey.
struct MotionFault {
  GateState cause = GateState::kRunaway;
  std::string reason;
};

class MotionMonitor {
 public:
  // `parameters` that GateParameters::check allows.
  explicit MotionMonitor(const GateParameters& parameters);

  // What the motors are told at `now` [s] of a clock that runs forward.
  void sent(double now, const Velocity& velocity);
  // What odometry that arrives at `now` measures; not finite: not taken. True when it brings the fault.
  bool measured(double now, const Velocity& velocity);
  // Somebody else has noticed `fault`. True when it is new.
  bool told(const MotionFault& fault);

  // Whether there is odometry to watch.
  bool watches(double now) const { return now - measured_ <= kOdometryTimeout; }
  // What is wrong: from the time when it is noticed until the chair has stood for kStandTime.
  const MotionFault& fault() const { return fault_; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

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
  MotionFault judge(double now, double elapsed);
  bool tooFast(Axis& axis, double now, double elapsed);
  bool wrongWay(Axis& axis, double now);
  bool keepsSpeed(double now);
  bool keepsSpeed(double now, double duration, double least_slower) const;
  bool oneMotorStands(double now);
  MotionFault fault(const Axis& axis, double now, GateState cause, const char* why) const;
  double least(const SpeedHistory::Range& range, double sign) const;
  bool lasts(double& since, double now, bool wrong, double duration) const;
  void clearWhenStanding(double now, const Velocity& velocity);

  double delay_, gain_, time_;
  std::array<Axis, 2> axes_;
  SpeedHistory sent_, moves_;
  double keeps_since_ = kNever, lame_since_ = kNever;  // [s] keepsSpeed, oneMotorStands
  double measured_ = -kNever;
  double stands_since_ = kNever;
  MotionFault fault_;
};

}  // namespace seater_safety
