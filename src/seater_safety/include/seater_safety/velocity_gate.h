// The last gate before the motors, without ROS.
//
// The output is always finite and within the limits of speed and acceleration. Requests pass while their sender holds
// a consent, which is asked for once per goal (`arm`). Emergency stop, joystick, silence, a request that is not finite
// and a fault end the consent: from then on the output is zero until somebody asks anew, whatever comes in. Only the
// joystick needs no consent.
//
// Times are seconds of one clock that runs forward; a jump backward ends the consent. Speeds are m/s and rad/s in
// base_link (x forward, anticlockwise positive).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "seater_safety/consent.h"
#include "seater_safety/gate_parameters.h"
#include "seater_safety/gate_state.h"
#include "seater_safety/joystick.h"
#include "seater_safety/obstacle_guard.h"
#include "seater_safety/ramp.h"
#include "seater_safety/speed_zone.h"

namespace seater_safety {

// A smaller step backward of the clock, or stamp in the future, is lateness of a message.
constexpr double kLateness = 0.25;  // [s]

// Why no consent is given.
struct Refusal {
  GateState state;
  std::string reason;
};

class VelocityGate {
 public:
  // Throws std::invalid_argument with the text of GateParameters::check.
  // `required`: sources of obstacles without which no request passes.
  explicit VelocityGate(const GateParameters& parameters, const std::vector<std::string>& required = {});

  // The time [s] of a request: `now`, or its stamp where that is a little later. Simulated time and a request stamped
  // with it arrive on two connections in either order; with the stamp the output does not depend on the order. A stamp
  // far in the future is ignored.
  static double requestTime(double now, double stamp);

  // `holder` asks that its requests pass: a person has given it a goal. Empty: they do from now on. `undock`: the goal
  // leaves the dock, the only one that may while the chair charges.
  std::optional<Refusal> arm(double now, const std::string& holder, bool undock = false);

  // A velocity request; `age` [s]: from its stamp until now, by the clock of the stamp; infinite: it has no stamp. It
  // is used when its sender holds the consent and its age is within -kLateness .. request_max_age. One that is not
  // finite, or comes from somebody else while a consent is held, ends the consent.
  void request(double now, const std::string& sender, const Velocity& velocity, double age = 0.0);
  // A joystick command of the person in the seat. Deflected: it has precedence, and the consent ends. Not finite: the
  // joystick counts as let go, and the consent ends.
  void user(double now, const Velocity& velocity);
  // With the parameter hold_to_run: requests pass while a person holds a button; let go, the consent ends.
  void holdToRun(double now, bool held);
  // While pressed, the output is zero; with emergency_stop_timeout also while nothing was said for so long, and with
  // emergency_stop_reset until a reset.
  void emergencyStop(double now, bool pressed);
  // The charging contact. With charging_inhibit nothing moves while it is closed and no consent is held: one that was
  // given before ends as it would, since a docking closes the contact before it is over.
  void charging(double now, bool closed);
  // After an emergency stop, standing with the joystick let go. Empty: done, or there was nothing to do.
  std::optional<Refusal> reset(double now);
  // The largest speed [m/s] where the chair is, both ways and whoever drives, from the time `from` [s] on; see
  // SpeedZone.
  void speedLimit(double from, double limit);
  // What a sensor of obstacles sees; see ObstacleGuard::seen. It slows down and stops requests, and the joystick where
  // obstacle_joystick says so. A required source that is silent, or one that sees nothing, ends the consent.
  void obstacles(double from, double measured, const std::string& source, std::vector<Point> points,
                 const std::string& blocked = "");
  // Something round the gate is wrong: zero until `reason` is empty again. `cause`: the state that says so.
  void fault(double now, const std::string& reason, GateState cause = GateState::kFault);
  // The same when the motors do not obey: zero at once, and no power for them until somebody drives anew after the end
  // of the fault. A base that runs away by itself would start again with each try. `cause`: kRunaway or
  // kWrongDirection.
  void cutPower(double now, GateState cause, const std::string& reason);

  // Ends the consent when its holder was silent for too long; `output` does the same.
  void expire(double now);
  // The velocity for the motors at `now` [s]. To be called after each input and at a steady rate without inputs.
  Velocity output(double now);

  // Whether the motors may have power: not during an emergency stop or a fault, once the output is zero; see
  // also cutPower.
  bool motorsEnabled(double now) const {
    return !power_cut_ && (moving() || (emergency(now).empty() && fault_.empty()));
  }

  GateState state() const { return state_; }
  GateStatus status(double now) const;
  // Requests and joystick commands that were not finite, since the start.
  unsigned refused() const { return refused_; }
  // Requests without consent, or too old or too new, since the start.
  unsigned ignored() const { return ignored_; }
  // Outputs that differ from the request because of a speed limit, since the start.
  unsigned limited() const { return limited_; }

 private:
  std::string reason(double now) const;
  void notice(double now);
  void stop(double now, GateState cause, const std::string& reason);
  void latchEmergencyStop(double now, const std::string& reason);
  bool holds(double now) const;
  std::string emergency(double now) const;
  bool charges() const { return parameters_.charging_inhibit != 0.0 && closed_; }
  bool inhibited() const { return charges() && !consent_.held(); }
  bool moving() const { return linear_.speed() != 0.0 || angular_.speed() != 0.0; }
  bool insistent(double now) const;
  Velocity wanted(double now);
  Velocity requested(double now);
  Velocity kept(double now, const Velocity& bounded);

  GateParameters parameters_;
  Joystick joystick_;
  Consent consent_;
  Velocity request_;           // the last one that was accepted
  double request_time_ = 0.0;  // of it, or of the consent
  bool request_seen_ = false;  // since the consent
  double armed_time_ = 0.0;    // when the last consent was given
  double insisted_ = -1e9;     // when a request other than zero came last, accepted or not
  std::string unused_;         // why the last request was not accepted
  bool held_ = false;          // hold-to-run, as it was said last
  double held_time_ = 0.0;     // of that
  bool pressed_ = false;       // the emergency stop, as it was said last
  bool pressed_seen_ = false;
  double pressed_time_ = 0.0;  // of the last message, or of the start
  bool reset_due_ = false;
  bool closed_ = false;  // the charging contact, as it was said last
  std::string fault_;
  GateState fault_state_ = GateState::kFault;
  bool power_cut_ = false;
  SpeedZone zone_;
  ObstacleGuard guard_;
  Ramp linear_, angular_;
  double last_time_ = 0.0;
  bool started_ = false;
  GateState state_ = GateState::kStopped;
  unsigned refused_ = 0;
  unsigned ignored_ = 0;
  unsigned limited_ = 0;
};

}  // namespace seater_safety
