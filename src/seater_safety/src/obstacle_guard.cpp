#include "seater_safety/obstacle_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "words.h"

namespace seater_safety {
namespace {

constexpr double kStep = 0.02;     // [m] between the places of the footprint that are looked at
constexpr double kCreep = 0.001;   // [m] by which a point within the margin may come nearer: rounding
constexpr double kHold = 0.05;     // [s] until the next look at a command
constexpr double kSlowest = 0.02;  // [m/s] slower is no driving, but creeping up to something
constexpr double kCalm = 0.5;      // [s] after a stop: no stop and go at the edge of a zone
constexpr double kPause = 1.0;     // [s] between two looks: nobody looked
constexpr double kMemory = 5.0;    // [s] of what was sent; no measurement that counts is older
constexpr std::size_t kSources = 16, kPoints = 20000;  // more are no sensors of a chair, and would take the gate's time
constexpr double kFree = std::numeric_limits<double>::infinity();

}  // namespace

ObstacleGuard::ObstacleGuard(const GateParameters& parameters, std::vector<std::string> required)
    : parameters_(parameters),
      required_(std::move(required)),
      reach_(std::hypot(std::max(parameters.length_front, parameters.length_rear), 0.5 * parameters.width)) {}

void ObstacleGuard::seen(double from, double measured, const std::string& source, std::vector<Point> points,
                         const std::string& blocked) {
  Sight sight{from, std::min(measured, from), std::move(points), blocked};
  const auto finite = [](const Point& point) { return std::isfinite(point.x) && std::isfinite(point.y); };
  if (!std::all_of(sight.points.begin(), sight.points.end(), finite)) sight.blocked = "a point is not finite";
  const bool many = sight.points.size() > kPoints, another = sights_.count(source) == 0 && sights_.size() >= kSources;
  if (many) sight.blocked = "too many points";
  if (another) sight.blocked = "too many sources";
  if (many || another) sight.points.clear();
  std::deque<Sight>& sights = sights_[another ? "others" : source];
  while (!sights.empty() && sights.back().from >= from) sights.pop_back();
  sights.push_back(std::move(sight));
}

void ObstacleGuard::sent(double now, const Velocity& velocity) {
  while (sent_.size() > 1 && sent_[1].time <= now - kMemory) sent_.pop_front();
  sent_.push_back({now, rate(velocity)});
}

void ObstacleGuard::forget() {
  sights_.clear();
  sent_.clear();
  looked_ = calm_until_ = -1e18;
  reason_.clear();
}

double ObstacleGuard::rate(const Velocity& velocity) const {
  return std::abs(velocity.linear) + reach_ * std::abs(velocity.angular);
}

// The newest that counts; null when it is too old, or was measured too long before.
const ObstacleGuard::Sight* ObstacleGuard::current(double now, const std::string& source) {
  std::deque<Sight>& sights = sights_[source];
  while (sights.size() > 1 && sights[1].from <= now) sights.pop_front();
  if (sights.empty() || sights.front().from > now) return nullptr;
  return now - sights.front().measured <= parameters_.obstacle_timeout ? &sights.front() : nullptr;
}

std::string ObstacleGuard::blind(double now) {
  if (now - looked_ > kPause || now < looked_) looks_since_ = now;
  looked_ = now;
  for (const std::string& source : required_) {
    const bool waited = now - looks_since_ > parameters_.obstacle_timeout;
    if (waited && current(now, source) == nullptr) return "the sensor of obstacles (" + source + ") is silent";
  }
  for (const auto& [source, sights] : sights_) {
    const Sight* sight = current(now, source);
    if (sight != nullptr && !sight->blocked.empty()) {
      return "the sensor of obstacles (" + source + ") sees nothing: " + sight->blocked;
    }
  }
  return {};
}

Velocity ObstacleGuard::limited(double now, const Velocity& wanted) {
  reason_.clear();
  if (zero(wanted)) return wanted;
  double least = 1.0;
  for (const auto& [source, sights] : sights_) {
    const Sight* sight = current(now, source);
    if (sight != nullptr && sight->blocked.empty()) least = std::min(least, share(now, wanted, *sight));
  }
  if (least == 0.0) calm_until_ = now + kCalm;
  if (least < 1.0 && least > 0.0 && now < calm_until_) {
    least = 0.0;
    reason_ = "stopped: waits until the way is free, as something was in the way";
  }
  return {least * wanted.linear, least * wanted.angular};
}

// s with s hold + s^2 braking / 2 = way / rate, times in seconds: the command scaled by s holds until the next look,
// and then the chair brakes.
double ObstacleGuard::share(double now, const Velocity& wanted, const Sight& sight) {
  const double speed = rate(wanted);
  const double braking =
      std::max(std::abs(wanted.linear) / parameters_.a_max, std::abs(wanted.angular) / parameters_.alpha_max);
  const double behind = committed(now, sight.measured - parameters_.motion_delay);
  const double horizon = behind + speed * (kHold + 0.5 * braking);
  const double free = freeWay(wanted, speed, horizon, sight.points);
  if (free >= horizon) return 1.0;
  const double left = std::max(0.0, free - behind) / speed;
  const double scale = (std::sqrt(kHold * kHold + 2.0 * braking * left) - kHold) / braking;
  const bool stops = scale * speed < kSlowest;
  std::ostringstream text;
  text.precision(2);
  text << (stops ? "stopped" : "slowed down") << ": something is in the way, " << std::fixed << free << " m on";
  reason_ = text.str();
  return stops ? 0.0 : std::min(scale, 1.0);
}

// The way that the motors were told since `since` [s], up to now.
double ObstacleGuard::committed(double now, double since) const {
  double way = 0.0, until = now;
  for (auto sent = sent_.rbegin(); sent != sent_.rend() && until > since; ++sent) {
    way += sent->rate * std::max(0.0, until - std::max(sent->time, since));
    until = std::min(until, sent->time);
  }
  return way;
}

// From the footprint to a point in base_link [m]; negative inside.
double ObstacleGuard::distance(double x, double y) const {
  const double dx = std::max(-parameters_.length_rear - x, x - parameters_.length_front);
  const double dy = std::abs(y) - 0.5 * parameters_.width;
  if (dx <= 0.0 && dy <= 0.0) return std::max(dx, dy);
  return std::hypot(std::max(dx, 0.0), std::max(dy, 0.0));
}

// The way [m] along the arc until the first point is too near; kFree: none is, up to `horizon`.
double ObstacleGuard::freeWay(const Velocity& wanted, double rate, double horizon,
                              const std::vector<Point>& points) const {
  struct Near {
    Point point;
    double allowed;
  };
  std::vector<Near> near;
  for (const Point& point : points) {
    const double here = distance(point.x, point.y);
    if (here > horizon + parameters_.obstacle_margin) continue;
    near.push_back({point, std::min(parameters_.obstacle_margin, here - kCreep)});
  }
  const int steps = near.empty() ? 0 : static_cast<int>(std::ceil(horizon / kStep));
  for (int i = 1; i <= steps; ++i) {
    const double time = i * kStep / rate, turn = wanted.angular * time, half = 0.5 * turn;
    const double chord = wanted.linear * time * (half == 0.0 ? 1.0 : std::sin(half) / half);
    const double x = chord * std::cos(half), y = chord * std::sin(half), c = std::cos(turn), s = std::sin(turn);
    for (const auto& [point, allowed] : near) {
      const double dx = point.x - x, dy = point.y - y;
      if (distance(c * dx + s * dy, c * dy - s * dx) < allowed) return (i - 1) * kStep;
    }
  }
  return kFree;
}

}  // namespace seater_safety
