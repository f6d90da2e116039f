#include "seater_safety/motion_monitor.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

namespace seater_safety {
namespace {

constexpr double kBrakes = 0.5;        // times a_max and alpha_max: a chair slows down by at least this
constexpr double kWrongWayTime = 1.0;  // [s] told the same way for so long, or for the delay where that is longer
constexpr Velocity kStands{0.02, 0.05};

// A chair that is told to slow down slows down, if late: see keepsSpeed.
struct Window {
  double duration;  // [s]
  double slower;    // [m/s] told to slow down by at least this in it
};
constexpr Window kWindows[] = {{0.4, 0.08}, {0.7, 0.1}};  // the longer one: into a bay it is told so gently
constexpr double kWindow = kWindows[1].duration;          // [s] the longest
constexpr double kFollows = 1 / 3.0;                      // times that: the chair slows down by at least this
constexpr double kLagStep = 0.05;                         // [s] between the lags that are looked at
constexpr double kKeepsTime = 0.1;                        // [s] how long it has to last

// With one motor a chair drives at half the speed and turns about the wheel that stands: see oneMotorStands.
constexpr double kDriven = 0.12;       // [m/s] told at least; below, castors turn a chair as much
constexpr double kHalf = 0.65;         // times what was told at most
constexpr double kTurns = 0.13;        // [rad/s] beyond what was told at least
constexpr double kCurvature = 1.4;     // [1/m] at least; 2 / track with one wheel at rest, less when castors push it
constexpr double kOneMotorTime = 0.3;  // [s] how long it has to last

double sign(double value) {
  return std::copysign(1.0, value);
}

}  // namespace

MotionMonitor::MotionMonitor(const GateParameters& p)
    : delay_(p.motion_delay),
      gain_(p.motion_gain),
      time_(p.motion_time),
      axes_{Axis{&Velocity::linear, "drives", "m/s", p.motion_speed, kBrakes * p.a_max, 0.05},
            Axis{&Velocity::angular, "turns", "rad/s", p.motion_turning, kBrakes * p.alpha_max, 0.2}},
      sent_(std::max(p.motion_delay + kWindow, kWrongWayTime)),
      moves_(kWindow) {}

void MotionMonitor::sent(double now, const Velocity& velocity) {
  sent_.add(now, velocity);
}

bool MotionMonitor::measured(double now, const Velocity& velocity) {
  if (!std::isfinite(velocity.linear) || !std::isfinite(velocity.angular)) return false;
  if (!watches(now)) forget();
  const double elapsed = watches(now) ? std::max(0.0, now - measured_) : 0.0;
  measured_ = now;
  moves_.add(now, velocity);
  if (!fault_.reason.empty()) {
    clearWhenStanding(now, velocity);
    return false;
  }
  fault_ = judge(now, elapsed);
  return !fault_.reason.empty();
}

bool MotionMonitor::told(const MotionFault& fault) {
  if (!fault_.reason.empty()) return false;
  fault_ = fault;
  if (fault_.reason.empty()) fault_.reason = "told without a reason";
  stands_since_ = kNever;
  return true;
}

// After a pause the first speed counts as explained, and the chair has to brake from there.
void MotionMonitor::forget() {
  for (Axis& axis : axes_) axis.bound = axis.beyond_since = axis.wrong_since = kNever;
  keeps_since_ = lame_since_ = stands_since_ = kNever;
  moves_.clear();
}

// All are looked at in each step, as each counts for how long it has lasted; the first that does is told.
MotionFault MotionMonitor::judge(double now, double elapsed) {
  MotionFault found;
  const auto note = [&](bool wrong, const Axis& axis, GateState cause, const char* why) {
    if (wrong && found.reason.empty()) found = fault(axis, now, cause, why);
  };
  for (Axis& axis : axes_) {
    note(tooFast(axis, now, elapsed), axis, GateState::kRunaway, "motor controller, brake, or somebody pushes?");
    note(wrongWay(axis, now), axis, GateState::kWrongDirection, "a motor or an encoder connected the wrong way?");
  }
  note(keepsSpeed(now), axes_[0], GateState::kRunaway, "it does not slow down: motor controller?");
  note(oneMotorStands(now), axes_[1], GateState::kRunaway, "a motor without power, or a wheel that is stuck?");
  return found;
}

MotionFault MotionMonitor::fault(const Axis& axis, double now, GateState cause, const char* why) const {
  const SpeedHistory::Range told = sent_.range(now - delay_, axis.of);
  const double most = std::abs(told.least) > std::abs(told.most) ? told.least : told.most;
  std::ostringstream out;
  out.precision(2);
  out << "the chair " << axis.moves << " at " << std::fixed << moves_.at(now).*axis.of << " " << axis.unit << ", told "
      << most << " at most (" << why << ")";
  return {cause, out.str()};
}

bool MotionMonitor::tooFast(Axis& axis, double now, double elapsed) {
  const SpeedHistory::Range told = sent_.range(now - delay_, axis.of);
  const double speed = std::abs(moves_.at(now).*axis.of);
  // A chair that braked below the bound may not speed up again unless it is told to.
  axis.bound = std::max(gain_ * std::max(std::abs(told.least), std::abs(told.most)),
                        std::min(axis.bound - axis.braking * elapsed, speed));
  return lasts(axis.beyond_since, now, speed > axis.bound + axis.margin, time_);
}

bool MotionMonitor::wrongWay(Axis& axis, double now) {
  const double since = now - std::max(delay_, kWrongWayTime), speed = moves_.at(now).*axis.of;
  const bool fast = std::abs(speed) > axis.wrong_way;
  const bool against = fast && least(sent_.range(since, axis.of), -sign(speed)) >= axis.wrong_way;
  return lasts(axis.wrong_since, now, against && sent_.reaches(since), time_);
}

// The motors of a chair that obeys answer with lags between zero and motion_delay, in any mixture (delay, ramp, first
// order). So it slows down by as much as the commands did at the lag where they did so least. Slopes and castors change
// its speed, too, but by less than (1 - kFollows) of that within the window.
bool MotionMonitor::keepsSpeed(double now) {
  const bool keeps = std::any_of(std::begin(kWindows), std::end(kWindows), [this, now](const Window& window) {
    return keepsSpeed(now, window.duration, window.slower);
  });
  return lasts(keeps_since_, now, keeps, kKeepsTime);
}

bool MotionMonitor::keepsSpeed(double now, double duration, double least_slower) const {
  const double speed = moves_.at(now).linear, forward = sign(speed);
  const auto told = [this, forward](double time) { return forward * sent_.at(time).linear; };
  double slower = kNever;
  for (double lag = 0.0; lag < delay_ + 0.5 * kLagStep; lag += kLagStep) {
    slower = std::min(slower, told(now - lag - duration) - told(now - lag));
  }
  // In the second half of the window, too: a late chair may have begun to slow down within it.
  const auto follows = [this, now, forward, speed](double window) {
    return forward * (moves_.at(now - window).linear - speed) / window;
  };
  const double least = kFollows * slower / duration;
  const bool known = moves_.reaches(now - duration) && sent_.reaches(now - delay_ - duration);
  const bool keeps = known && slower >= least_slower && std::max(follows(duration), follows(0.5 * duration)) < least;
  return keeps && std::abs(speed) > told(now) + least_slower;
}

bool MotionMonitor::oneMotorStands(double now) {
  const Velocity moves = moves_.at(now);
  const double told = least(sent_.range(now - delay_, &Velocity::linear), sign(moves.linear));
  const SpeedHistory::Range turn = sent_.range(now - delay_, &Velocity::angular);
  // A chair that has not yet turned as far as it was told to is late.
  const double beyond = std::max(moves.angular - std::max(turn.most, 0.0), std::min(turn.least, 0.0) - moves.angular);
  const double speed = std::abs(moves.linear), rate = std::abs(moves.angular);
  const bool turns = beyond >= kTurns && rate >= std::max(kTurns, kCurvature * speed);
  const bool lame = told >= kDriven && speed <= kHalf * told && turns && sent_.reaches(now - delay_);
  return lasts(lame_since_, now, lame, kOneMotorTime);
}

// The least of the speeds in a range, counted in the direction of `sign`; negative where one goes the other way.
double MotionMonitor::least(const SpeedHistory::Range& range, double sign) const {
  return std::min(sign * range.least, sign * range.most);
}

bool MotionMonitor::lasts(double& since, double now, bool wrong, double duration) const {
  since = wrong ? std::min(since, now) : kNever;
  return wrong && now - since >= duration;
}

void MotionMonitor::clearWhenStanding(double now, const Velocity& velocity) {
  const bool stands = std::abs(velocity.linear) <= kStands.linear && std::abs(velocity.angular) <= kStands.angular;
  stands_since_ = stands ? std::min(stands_since_, now) : kNever;
  if (now - stands_since_ < kStandTime) return;
  fault_ = {};
  forget();
}

}  // namespace seater_safety
