#pragma once

#include <algorithm>

#include "seater_safety/gate_parameters.h"

namespace seater_safety {

// What may move the chair, written down a second time and without the gate's own words.
struct Model {
  GateParameters p;
  int holder = -1;         // of the consent; -1: none
  double accepted = -1e9;  // when a usable request came last, or the consent was given
  double insisted = -1e9;  // when anyone asked for motion last
  bool asks = false;       // there was a usable request in this consent
  bool zero = true;        // it was zero
  bool awry = false;       // requests came since that could not be used
  bool pressed = false, heard = false, faulty = false, reset_due = false;
  double pressed_at = -1e9;
  double deflected_at = -1e9;           // last joystick command above neutral
  bool deflected = false;               // the newest command is
  double user_at = 0.0;                 // of the newest command, or of the start
  double zone = 0.0, zone_from = -1e9;  // largest speed here, and since when
  bool hold = false;                    // hold-to-run, as it was said last
  double hold_at = -1e9;
  bool charging = false;   // as it was said last
  bool powerless = false;  // cut, and nobody drives since
  bool let_go = false;     // since the last stop
  double locked_at = 0.0;

  bool emergency(double now) const {
    const bool silent = p.emergency_stop_timeout > 0.0 && (!heard || now - pressed_at > p.emergency_stop_timeout);
    return pressed || silent || reset_due;
  }
  bool held(double now) const { return p.hold_to_run == 0.0 || (hold && now - hold_at <= p.user_timeout); }
  bool stopped(double now) const { return emergency(now) || faulty; }
  void look(double now) {
    if (stopped(now)) {
      holder = -1;
      let_go = false;
      locked_at = now;
      reset_due = emergency(now) && p.emergency_stop_reset != 0.0;
    } else if (now - std::max(user_at, locked_at) > p.user_timeout) {
      let_go = true;
    }
    if (!held(now)) holder = -1;
    const double patience = zero && !awry ? p.consent_idle_timeout : p.consent_timeout;
    if (holder >= 0 && now - accepted > patience) holder = -1;
    if (inhibited()) {
      let_go = false;
      locked_at = now;
    }
  }
  bool charges() const { return p.charging_inhibit != 0.0 && charging; }
  bool inhibited() const { return charges() && holder < 0; }
  bool userDrives(double now) const { return let_go && deflected && now - user_at <= p.user_timeout; }
  bool requestDrives(double now) const { return holder >= 0 && asks && now - accepted <= p.request_timeout; }
  bool mayMove(double now) const { return !stopped(now) && (userDrives(now) || requestDrives(now)); }
};

}  // namespace seater_safety
