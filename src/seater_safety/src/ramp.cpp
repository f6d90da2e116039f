#include "seater_safety/ramp.h"

#include <algorithm>
#include <cmath>

namespace seater_safety {

double Ramp::advance(double wanted, double duration) {
  const bool crosses = speed_ * wanted < 0.0;
  if (crosses || std::abs(wanted) <= std::abs(speed_)) {
    const double step = limits_.slower * duration;
    const double aim = crosses ? 0.0 : wanted;
    speed_ = std::clamp(aim, speed_ - step, speed_ + step);
    acceleration_ = 0.0;
  } else if (duration > 0.0) {
    speed_ = faster(wanted, duration);
  }
  return speed_;
}

// sqrt(2 jerk gap): from this acceleration, brought to zero within the jerk, the speed comes to rest at `wanted`.
double Ramp::faster(double wanted, double duration) {
  const double gap = std::abs(wanted - speed_);
  acceleration_ =
      std::min({limits_.faster, acceleration_ + limits_.jerk * duration, std::sqrt(2.0 * limits_.jerk * gap)});
  const double step = acceleration_ * duration;
  return std::clamp(wanted, speed_ - step, speed_ + step);
}

}  // namespace seater_safety
