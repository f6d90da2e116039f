#include "clocks.h"

#include <limits>
#include <stdexcept>

namespace seater_safety {

Clocks::Clocks(bool lock_step) : lock_step_(lock_step) {
  const bool simulated = !ros::Time::isSystemTime();
  if (simulated && !lock_step) {
    throw std::invalid_argument(
        "/use_sim_time: is true, but this is no simulation in lock-step (~lock_step). A simulation has left it on this "
        "ROS master: rosparam delete /use_sim_time, or start another master");
  }
  if (lock_step && !simulated) throw std::invalid_argument("~lock_step: is true, which needs /use_sim_time");
}

double Clocks::now() const {
  return lock_step_ ? ros::Time::now().toSec() : ros::SteadyTime::now().toSec();
}

// Not by ros::Duration, which throws where it cannot hold the difference.
double Clocks::age(const ros::Time& stamp) {
  return stamp.isZero() ? std::numeric_limits<double>::infinity() : ros::Time::now().toSec() - stamp.toSec();
}

std::string Clocks::check() {
  return lock_step_ ? std::string() : monitor_.check(ros::SteadyTime::now().toSec(), ros::Time::now().toSec());
}

}  // namespace seater_safety
