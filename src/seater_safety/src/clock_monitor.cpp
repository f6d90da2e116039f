#include "seater_safety/clock_monitor.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace seater_safety {
namespace {

constexpr double kTolerance = 0.25;  // [s] half the age that a request may have (request_max_age)
constexpr double kSlew = 0.1;        // [s/s] chrony's fastest correction is 0.083 s/s
constexpr double kHold = 1.0;        // [s]

}  // namespace

std::string ClockMonitor::check(double steady, double other) {
  const double offset = other - steady;
  if (!started_) offset_ = offset;
  const double slew = started_ ? kSlew * std::max(0.0, steady - last_) : 0.0;
  started_ = true;
  last_ = steady;
  offset_ += std::clamp(offset - offset_, -slew, slew);
  if (!(std::abs(offset - offset_) <= kTolerance)) {
    std::ostringstream text;
    text << "the clock of ROS stands, jumps or was set: " << std::showpos << offset - offset_ << " s";
    fault_ = text.str();
    faulty_until_ = steady + kHold;
    offset_ = offset;
  }
  return steady < faulty_until_ ? fault_ : std::string();
}

}  // namespace seater_safety
