#include "seater_safety/gate_parameters.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace seater_safety {
namespace {

std::string wrong(const std::string& key, double value, const std::string& allowed) {
  std::ostringstream text;
  text << key << ": is " << value << ", must be " << allowed;
  return text.str();
}

std::string range(const GateParameter& parameter) {
  std::ostringstream text;
  text << "within " << parameter.low << " .. " << parameter.high << " " << parameter.unit;
  return text.str();
}

}  // namespace

// Ranges of the chair: those of seater_common.geometry. Of the gate: a stop from walking speed takes at most 1.2 s, and
// no time-out lets a chair at that speed drive on for more than its own length.
const std::vector<GateParameter>& gateParameters() {
  using P = GateParameters;
  static const std::vector<GateParameter> all = {
      {"chair", "length_front", &P::length_front, "m", 0.0, 3.0, "footprint ahead of the axle"},
      {"chair", "length_rear", &P::length_rear, "m", 0.0, 3.0, "footprint behind the axle"},
      {"chair", "width", &P::width, "m", 0.1, 3.0, "footprint across"},
      {"chair/limits", "v_max", &P::v_max, "m/s", 0.01, 3.0, "largest forward speed"},
      {"chair/limits", "v_reverse_max", &P::v_reverse_max, "m/s", 0.01, 3.0, "largest backward speed"},
      {"chair/limits", "omega_max", &P::omega_max, "rad/s", 0.01, 4.0, "largest turning rate, both ways"},
      {"chair/limits", "a_max", &P::a_max, "m/s^2", 0.01, 5.0, "speeding up"},
      {"chair/limits", "alpha_max", &P::alpha_max, "rad/s^2", 0.01, 10.0, "turning faster"},
      {"safety", "a_stop", &P::a_stop, "m/s^2", 0.5, 10.0, "slowing down; at least a_max: comfort delays no stop"},
      {"safety", "alpha_stop", &P::alpha_stop, "rad/s^2", 1.0, 20.0, "slowing the turn down; at least alpha_max"},
      {"safety", "request_timeout", &P::request_timeout, "s", 0.05, 0.5, "brakes when the newest request is older"},
      {"safety", "request_max_age", &P::request_max_age, "s", 0.1, 1.0, "a request with an older stamp is refused"},
      {"safety", "consent_timeout", &P::consent_timeout, "s", 0.1, 2.0,
       "the consent ends when the one who drives is silent for so long"},
      {"safety", "consent_idle_timeout", &P::consent_idle_timeout, "s", 0.5, 30.0,
       "the same while zero was requested last"},
      {"safety", "user_timeout", &P::user_timeout, "s", 0.1, 1.0, "a joystick that is silent for so long is let go"},
      {"safety", "user_neutral", &P::user_neutral, "m/s, rad/s", 0.001, 0.1,
       "a joystick command up to this counts as let go"},
      {"safety", "jerk_max", &P::jerk_max, "m/s^3", 0.5, 100.0, "change of acceleration; a stop is exempt"},
      {"safety", "angular_jerk_max", &P::angular_jerk_max, "rad/s^3", 1.0, 200.0, "the same for turning"},
      {"safety", "emergency_stop_timeout", &P::emergency_stop_timeout, "s", 0.0, 2.0,
       "an emergency stop that is silent for so long counts as pressed; 0: it need not speak"},
      {"safety", "emergency_stop_reset", &P::emergency_stop_reset, "", 0.0, 1.0,
       "1: an emergency stop lasts until it is reset by the service gate_reset; 0: until it is released"},
      {"safety", "hold_to_run", &P::hold_to_run, "", 0.0, 1.0,
       "1: requests pass only while hold_to_run is told true, silence of user_timeout counts as let go; 0: without"},
      {"safety", "charging_inhibit", &P::charging_inhibit, "", 0.0, 1.0,
       "1: while the charging contact is closed nothing moves until a goal undocks, the joystick neither; 0: without"},
      {"safety", "motion_delay", &P::motion_delay, "s", 0.2, 2.0, "a command acts after this at the latest"},
      {"safety", "motion_gain", &P::motion_gain, "", 1.0, 2.0, "speed over command up to which nothing is wrong"},
      {"safety", "motion_speed", &P::motion_speed, "m/s", 0.02, 0.3, "and beyond that the speed that is a fault"},
      {"safety", "motion_turning", &P::motion_turning, "rad/s", 0.05, 1.0, "the same for turning"},
      {"safety", "motion_time", &P::motion_time, "s", 0.05, 0.5, "how long it has to last"},
      {"safety", "obstacle_margin", &P::obstacle_margin, "m", 0.0, 0.3,
       "the footprint keeps so far from what a sensor of obstacles sees"},
      {"safety", "obstacle_timeout", &P::obstacle_timeout, "s", 0.1, 2.0,
       "a sensor of obstacles that is silent for so long sees nothing; it stops the docking where it is required"},
      {"safety", "obstacle_joystick", &P::obstacle_joystick, "", 0.0, 1.0,
       "1: what it sees slows down and stops the joystick, too; 0: the docking only"},
  };
  return all;
}

std::string GateParameters::check() const {
  for (const GateParameter& parameter : gateParameters()) {
    const double value = this->*parameter.value;
    const bool inside = std::isfinite(value) && value >= parameter.low && value <= parameter.high;
    if (!inside) return wrong(parameter.key, value, range(parameter));
  }
  if (a_stop < a_max) return wrong("a_stop", a_stop, "at least a_max of the chair");
  if (alpha_stop < alpha_max) return wrong("alpha_stop", alpha_stop, "at least alpha_max of the chair");
  if (consent_timeout < request_timeout) return wrong("consent_timeout", consent_timeout, "at least request_timeout");
  const bool heartbeat = emergency_stop_timeout == 0.0 || emergency_stop_timeout >= 0.1;
  if (!heartbeat) return wrong("emergency_stop_timeout", emergency_stop_timeout, "0, or at least 0.1 s");
  const auto flag = [](double value) { return value == 0.0 || value == 1.0; };
  if (!flag(emergency_stop_reset)) return wrong("emergency_stop_reset", emergency_stop_reset, "0 or 1");
  if (!flag(hold_to_run)) return wrong("hold_to_run", hold_to_run, "0 or 1");
  if (!flag(charging_inhibit)) return wrong("charging_inhibit", charging_inhibit, "0 or 1");
  if (!flag(obstacle_joystick)) return wrong("obstacle_joystick", obstacle_joystick, "0 or 1");
  if (request_max_age < request_timeout) return wrong("request_max_age", request_max_age, "at least request_timeout");
  return {};
}

std::string checkKeys(const std::string& file, const std::vector<std::string>& keys) {
  std::vector<std::string> known;
  for (const GateParameter& parameter : gateParameters()) {
    if (file == parameter.file) known.emplace_back(parameter.key);
  }
  const auto lacks = [](const std::vector<std::string>& list, const std::string& key) {
    return std::find(list.begin(), list.end(), key) == list.end();
  };
  for (const std::string& key : keys) {
    if (lacks(known, key)) return key + ": is no parameter of the safety gate";
  }
  for (const std::string& key : known) {
    if (lacks(keys, key)) return key + ": is missing";
  }
  return {};
}

}  // namespace seater_safety
