// Whether a clock that people, programs and networks can set runs like the steady clock. No ROS.
//
// The offset between both may change slowly, as when a clock is disciplined by NTP. A jump, or a clock that stands or
// runs far too fast, is a fault, and one for a second after its last sign: a clock that stands is set right at once
// and shows itself again.
#pragma once

#include <string>

namespace seater_safety {

class ClockMonitor {
 public:
  // Empty, or what is wrong. `steady` and `other` [s], both read now; to be called at least five times per second.
  std::string check(double steady, double other);

 private:
  bool started_ = false;
  double last_ = 0.0;            // [s] steady, of the last call
  double offset_ = 0.0;          // [s] other - steady, as it is expected to be
  double faulty_until_ = -1e18;  // [s] steady
  std::string fault_;
};

}  // namespace seater_safety
