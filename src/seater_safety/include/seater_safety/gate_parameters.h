// Limits and time-outs of the velocity gate, with the range of each. No ROS.
#pragma once

#include <string>
#include <vector>

namespace seater_safety {

struct GateParameters {
  // Of the chair (config/chair.yaml).
  double length_front = 0.75;
  double length_rear = 0.30;
  double width = 0.65;
  // Of its limits.
  double v_max = 0.6;
  double v_reverse_max = 0.3;
  double omega_max = 0.8;
  double a_max = 0.5;
  double alpha_max = 1.0;
  // Of the gate (config/safety.yaml).
  double a_stop = 1.5;
  double alpha_stop = 3.0;
  double request_timeout = 0.25;
  double request_max_age = 0.5;
  double consent_timeout = 0.8;
  double consent_idle_timeout = 5.0;
  double user_timeout = 0.5;
  double user_neutral = 0.02;
  double jerk_max = 12.0;
  double angular_jerk_max = 24.0;
  double emergency_stop_timeout = 0.0;
  double emergency_stop_reset = 0.0;
  double hold_to_run = 0.0;
  double charging_inhibit = 0.0;
  double motion_delay = 0.6;
  double motion_gain = 1.3;
  double motion_speed = 0.06;
  double motion_turning = 0.3;
  double motion_time = 0.15;
  double obstacle_margin = 0.03;
  double obstacle_timeout = 0.5;
  double obstacle_joystick = 1.0;

  // Empty when all values can be used; else key and value of the first wrong one and what is allowed.
  std::string check() const;
};

// One parameter as it stands in its file; `low` and `high` are allowed themselves.
struct GateParameter {
  const char* file;  // "chair", "chair/limits" or "safety"
  const char* key;
  double GateParameters::*value;
  const char* unit;
  double low;
  double high;
  const char* text;
};

// All of them, in the order of the struct.
const std::vector<GateParameter>& gateParameters();

// Empty when `keys` are the keys of `file`; else the first that is unknown or missing.
std::string checkKeys(const std::string& file, const std::vector<std::string>& keys);

}  // namespace seater_safety
