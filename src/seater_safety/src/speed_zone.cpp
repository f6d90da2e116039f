#include "seater_safety/speed_zone.h"

#include <algorithm>
#include <cmath>

namespace seater_safety {

bool SpeedZone::told(double from, double limit) {
  if (!std::isfinite(from) || !std::isfinite(limit) || limit < 0.0) return false;
  while (!told_.empty() && told_.back().from >= from) told_.pop_back();
  told_.push_back({from, limit});
  return true;
}

double SpeedZone::limit(double now, double speed, double change, double kept_since) {
  while (told_.size() > 1 && told_[1].from <= now) told_.pop_front();
  const bool told = !told_.empty() && told_.front().from <= now;
  const bool known = told && (told_.front().from >= kept_since || now - told_.front().from <= kZoneTimeout);
  if (!known) return std::numeric_limits<double>::infinity();
  return std::max(told_.front().limit, std::abs(speed) - change);
}

}  // namespace seater_safety
