// The largest speed where the chair is, as it is told by who knows the place. No ROS.
//
// On the way into a slow zone the limit falls within the comfortable acceleration. What was told counts for
// kZoneTimeout: who knows the place repeats it. What was told since a consent was given counts as long as it is held: a
// driver that has fallen silent about the place knows it no better.
#pragma once

#include <deque>
#include <limits>

namespace seater_safety {

constexpr double kZoneTimeout = 2.0;  // [s]

class SpeedZone {
 public:
  // `limit` [m/s] from the time `from` [s] on. One that is not finite or negative is not taken: false.
  bool told(double from, double limit);
  // At `now`, `change` [m/s] at most below the limit before where that was above the speed `speed` [m/s]. What was
  // told from `kept_since` [s] on is not forgotten.
  double limit(double now, double speed, double change, double kept_since = std::numeric_limits<double>::infinity());
  void forget() { told_.clear(); }

 private:
  struct Told {
    double from;
    double limit;
  };

  std::deque<Told> told_;  // in the order of their times; the first is in force
};

}  // namespace seater_safety
