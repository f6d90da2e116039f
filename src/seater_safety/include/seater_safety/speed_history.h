// Speeds of the last seconds, each in force until the next one. No ROS.
#pragma once

#include <deque>

#include "seater_safety/gate_state.h"

namespace seater_safety {

class SpeedHistory {
 public:
  struct Range {
    double least, most;
  };

  // Remembers what was in force at any time of the last `span` [s].
  explicit SpeedHistory(double span) : span_(span) {}

  // In force from `time` [s] on, which does not run backward.
  void add(double time, const Velocity& velocity);
  void clear() { entries_.clear(); }

  // Whether it goes back to `time`.
  bool reaches(double time) const { return !entries_.empty() && entries_.front().time <= time; }
  // What was in force at `time`; before the first, or without any: zero.
  Velocity at(double time) const;
  // Least and most of what was in force at any time of `since` .. the newest; without any: zero.
  Range range(double since, double Velocity::*of) const;

 private:
  struct Entry {
    double time;
    Velocity velocity;
  };

  double span_;
  std::deque<Entry> entries_;
};

}  // namespace seater_safety
