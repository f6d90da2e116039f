// One axis (speed or turning rate) on its way to what is wanted. No ROS.
#pragma once

namespace seater_safety {

// Away from zero: within acceleration and jerk, in an S-curve. Towards zero: within the harder deceleration at once, as
// a stop must not wait for comfort. Crossing zero stops at zero first.
class Ramp {
 public:
  struct Limits {
    double faster;  // [m/s^2] or [rad/s^2]
    double slower;
    double jerk;  // [m/s^3] or [rad/s^3]
  };

  explicit Ramp(const Limits& limits) : limits_(limits) {}

  // The speed after `duration` [s], which is at most kLongestStep of the gate.
  double advance(double wanted, double duration);
  // Zero at once, without braking: the motors have no power.
  void drop() { speed_ = acceleration_ = 0.0; }
  double speed() const { return speed_; }

 private:
  double faster(double wanted, double duration);

  Limits limits_;
  double speed_ = 0.0;         // [m/s] or [rad/s]
  double acceleration_ = 0.0;  // of speeding up, in the last step
};

}  // namespace seater_safety
