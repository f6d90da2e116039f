#include "seater_safety/joystick.h"

#include <algorithm>
#include <cmath>

namespace seater_safety {

Joystick::Joystick(const GateParameters& parameters, double now)
    : timeout_(parameters.user_timeout), neutral_(parameters.user_neutral), time_(now), locked_since_(now) {}

void Joystick::command(double now, const Velocity& velocity) {
  update(now);  // silence until now counts as let go
  velocity_ = velocity;
  time_ = now;
  seen_ = true;
  if (neutral()) locked_ = false;
}

void Joystick::lock(double now) {
  locked_ = true;
  locked_since_ = now;
}

void Joystick::update(double now) {
  if (now - std::max(time_, locked_since_) > timeout_) locked_ = false;
}

bool Joystick::neutral() const {
  return std::abs(velocity_.linear) <= neutral_ && std::abs(velocity_.angular) <= neutral_;
}

bool Joystick::deflected(double now) const {
  return seen_ && !neutral() && now - time_ <= timeout_;
}

}  // namespace seater_safety
