#include "seater_safety/motion_monitor.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace seater_safety {
namespace {

constexpr double kBrakes = 0.5;        // times a_max and alpha_max: a chair slows down by at least this
constexpr double kWrongWayTime = 1.0;  // [s] told the same way for so long, or for the delay where that is longer
constexpr Velocity kStands{0.02, 0.05};

std::string text(const char* moves, double speed, double told, const char* unit, const char* why) {
  std::ostringstream out;
  out.precision(2);
  out << "the chair " << moves << " at " << std::fixed << speed << " " << unit << ", told " << told << " at most ("
      << why << ")";
  return out.str();
}

}  // namespace

MotionMonitor::MotionMonitor(const GateParameters& p)
    : delay_(p.motion_delay),
      gain_(p.motion_gain),
      time_(p.motion_time),
      axes_{Axis{&Velocity::linear, "drives", "m/s", p.motion_speed, kBrakes * p.a_max, 0.05},
            Axis{&Velocity::angular, "turns", "rad/s", p.motion_turning, kBrakes * p.alpha_max, 0.2}} {}

void MotionMonitor::sent(double now, const Velocity& velocity) {
  sent_.push_back({now, velocity});
  const double oldest = now - std::max(delay_, kWrongWayTime);
  while (sent_.size() > 1 && sent_[1].time <= oldest) sent_.pop_front();
}

bool MotionMonitor::measured(double now, const Velocity& velocity) {
  if (!std::isfinite(velocity.linear) || !std::isfinite(velocity.angular)) return false;
  if (!watches(now)) forget();
  const double elapsed = watches(now) ? std::max(0.0, now - measured_) : 0.0;
  measured_ = now;
  if (!fault_.empty()) {
    clearWhenStanding(now, velocity);
    return false;
  }
  for (Axis& axis : axes_) {
    const std::string found = judge(axis, now, elapsed, velocity.*axis.of);
    if (fault_.empty()) fault_ = found;
  }
  return !fault_.empty();
}

// After a pause the first speed counts as explained, and the chair has to brake from there.
void MotionMonitor::forget() {
  for (Axis& axis : axes_) axis.bound = axis.beyond_since = axis.wrong_since = kNever;
  stands_since_ = kNever;
}

std::string MotionMonitor::judge(Axis& axis, double now, double elapsed, double speed) {
  const Range told = sentWithin(now, delay_, axis.of);
  const double most = std::max(std::abs(told.least), std::abs(told.most));
  // A chair that braked below the bound may not speed up again unless it is told to.
  axis.bound = std::max(gain_ * most, std::min(axis.bound - axis.braking * elapsed, std::abs(speed)));
  if (lasts(axis.beyond_since, now, std::abs(speed) > axis.bound + axis.margin)) {
    return text(axis.moves, speed, most, axis.unit, "motor controller, brake, or somebody pushes?");
  }
  const double duration = std::max(delay_, kWrongWayTime);
  const Range long_told = sentWithin(now, duration, axis.of);
  const bool against = (long_told.least >= axis.wrong_way && speed < -axis.wrong_way) ||
                       (long_told.most <= -axis.wrong_way && speed > axis.wrong_way);
  const bool wrong = against && !sent_.empty() && sent_.front().time <= now - duration;
  if (!lasts(axis.wrong_since, now, wrong)) return {};
  return text(axis.moves, speed, std::copysign(most, -speed), axis.unit,
              "a motor or an encoder connected the wrong way?");
}

// Least and most of what was in force at any time of the last `duration` [s]; zero before the first.
MotionMonitor::Range MotionMonitor::sentWithin(double now, double duration, double Velocity::*of) const {
  if (sent_.empty()) return {0.0, 0.0};
  Range range{sent_.back().velocity.*of, sent_.back().velocity.*of};
  for (auto sent = sent_.rbegin(); sent != sent_.rend(); ++sent) {
    range = {std::min(range.least, sent->velocity.*of), std::max(range.most, sent->velocity.*of)};
    if (sent->time <= now - duration) break;
  }
  return range;
}

bool MotionMonitor::lasts(double& since, double now, bool wrong) const {
  since = wrong ? std::min(since, now) : kNever;
  return wrong && now - since >= time_;
}

void MotionMonitor::clearWhenStanding(double now, const Velocity& velocity) {
  const bool stands = std::abs(velocity.linear) <= kStands.linear && std::abs(velocity.angular) <= kStands.angular;
  stands_since_ = stands ? std::min(stands_since_, now) : kNever;
  if (now - stands_since_ < kStandTime) return;
  fault_.clear();
  forget();
}

}  // namespace seater_safety
