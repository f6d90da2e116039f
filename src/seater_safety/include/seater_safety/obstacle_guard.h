// Keeps the commanded motion clear of what sensors of obstacles see. No ROS.
//
// The footprint is moved along the arc of the command, from where the chair was at the measurement. Where it would come
// nearer than obstacle_margin to a point, the way up to there has to suffice for what the motors were told since and
// do not yet act on (motion_delay), and for braking. Stop zone: it does not, the chair stops. Slow zone beyond it: the
// command is scaled, its arc kept, so that braking by a_max and alpha_max suffices. A point that is nearer than the
// margin already stops only what brings it nearer: the way out stays open. After a stop the chair does not creep on:
// for half a second only a way that is free altogether is taken.
//
// Ways are counted in metres that the outermost corner moves at most: |v| + reach |omega| per second.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "seater_safety/gate_parameters.h"
#include "seater_safety/gate_state.h"

namespace seater_safety {

// On the floor in base_link [m].
struct Point {
  double x, y;
};

class ObstacleGuard {
 public:
  // `required`: names of the sources without which no request passes.
  explicit ObstacleGuard(const GateParameters& parameters, std::vector<std::string> required = {});

  // What `source` has seen at the time `measured` [s], counting from the time `from` on: points in base_link as it was
  // at the measurement, all that the source knows. `blocked`, or a point that is not finite: why it can tell nothing.
  void seen(double from, double measured, const std::string& source, std::vector<Point> points,
            const std::string& blocked = "");
  // What the motors are told from `now` [s] on.
  void sent(double now, const Velocity& velocity);
  void forget();

  // Empty, or why the way is not known: a required source is silent for obstacle_timeout, or any is blocked. To be
  // called regularly: silence counts only while somebody looks.
  std::string blind(double now);
  // The command, scaled by 0 .. 1.
  Velocity limited(double now, const Velocity& wanted);
  // What limited it last, in words; empty: nothing.
  const std::string& reason() const { return reason_; }

 private:
  struct Sight {
    double from, measured;
    std::vector<Point> points;
    std::string blocked;
  };
  struct Sent {
    double time, rate;  // [s], [m/s] of the outermost corner
  };

  const Sight* current(double now, const std::string& source);
  double committed(double now, double since) const;
  double share(double now, const Velocity& wanted, const Sight& sight);
  double distance(double x, double y) const;
  double freeWay(const Velocity& wanted, double rate, double horizon, const std::vector<Point>& points) const;
  double rate(const Velocity& velocity) const;

  GateParameters parameters_;
  std::vector<std::string> required_;
  double reach_;  // [m] of the footprint from base_link
  std::map<std::string, std::deque<Sight>> sights_;
  std::deque<Sent> sent_;
  double calm_until_ = -1e18;                  // [s] after a stop
  double looked_ = -1e18, looks_since_ = 0.0;  // [s] the last look, and the first of those without a pause
  std::string reason_;
};

}  // namespace seater_safety
