// Small helpers of the velocity gate.
#pragma once

#include <sstream>
#include <string>

#include "seater_safety/gate_state.h"

namespace seater_safety {

constexpr const char* kInhibited = "the charging contact is closed: undock first";

inline bool zero(const Velocity& velocity) {
  return velocity.linear == 0.0 && velocity.angular == 0.0;
}

inline std::string seconds(const std::string& before, double value, const std::string& after) {
  std::ostringstream text;
  text.precision(2);
  text << before << std::fixed << value << " s" << after;
  return text.str();
}

}  // namespace seater_safety
