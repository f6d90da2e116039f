// The joystick of the person in the seat. No ROS.
//
// Deflected: its newest command is above neutral and recent. It drives while it is deflected, but after a lock only
// once it was let go: a joystick that is held at switch-on, or while a stop is released, moves nothing.
#pragma once

#include "seater_safety/gate_parameters.h"
#include "seater_safety/gate_state.h"

namespace seater_safety {

class Joystick {
 public:
  // Locked from `now` [s] on.
  Joystick(const GateParameters& parameters, double now);

  // A finite command.
  void command(double now, const Velocity& velocity);
  void lock(double now);
  // To be called before each look at it.
  void update(double now);

  bool deflected(double now) const;
  bool locked() const { return locked_; }
  bool drives(double now) const { return !locked_ && deflected(now); }
  const Velocity& velocity() const { return velocity_; }
  // Since the last command [s]; -1: none yet.
  double age(double now) const { return seen_ ? now - time_ : -1.0; }

 private:
  bool neutral() const;

  double timeout_, neutral_;
  Velocity velocity_;
  bool seen_ = false;
  double time_;  // of the last command, or of the start
  bool locked_ = true;
  double locked_since_;
};

}  // namespace seater_safety
