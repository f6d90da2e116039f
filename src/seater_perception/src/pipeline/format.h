// Numbers in texts.
#pragma once

#include <cstdio>
#include <string>

namespace seater_perception {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;  // in a radian

/// As std::printf has it; of what is longer than a line (255 characters) the rest is cut off.
template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof(line), pattern, values...);
  return line;
}

}  // namespace seater_perception
