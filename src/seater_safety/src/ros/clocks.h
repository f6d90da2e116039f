#pragma once

#include <ros/time.h>

#include <string>

#include "seater_safety/clock_monitor.h"

namespace seater_safety {

// Which time the gate goes by: the steady clock, which nobody can set; in a simulation in lock-step ROS time, so that
// a run does not depend on the speed of the machine.
class Clocks {
 public:
  // Throws std::invalid_argument: simulated time without lock-step, or lock-step without simulated time.
  explicit Clocks(bool lock_step);

  bool lockStep() const { return lock_step_; }
  // [s], for all time-outs.
  double now() const;
  // [s] from a stamp until now by ROS time; infinite: there is no stamp.
  static double age(const ros::Time& stamp);
  // Empty, or why ROS time cannot be trusted.
  std::string check();

 private:
  bool lock_step_;
  ClockMonitor monitor_;
};

}  // namespace seater_safety
