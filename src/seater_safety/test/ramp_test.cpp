#include "seater_safety/ramp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace seater_safety {
namespace {

constexpr Ramp::Limits kLimits{0.5, 1.5, 2.0};
constexpr double kStep = 0.01;  // [s]

std::vector<double> drive(Ramp& ramp, double wanted, double duration) {
  std::vector<double> speeds = {ramp.speed()};
  for (double t = 0.0; t < duration; t += kStep) speeds.push_back(ramp.advance(wanted, kStep));
  return speeds;
}

TEST(Ramp, SpeedsUpWithinAccelerationAndJerk) {
  for (const double sign : {1.0, -1.0}) {
    Ramp ramp(kLimits);
    const std::vector<double> speeds = drive(ramp, sign * 0.6, 3.0);
    double before = 0.0;
    for (std::size_t i = 1; i < speeds.size(); ++i) {
      const double acceleration = sign * (speeds[i] - speeds[i - 1]) / kStep;
      EXPECT_LE(acceleration, kLimits.faster + 1e-9);
      EXPECT_LE(acceleration - before, kLimits.jerk * kStep + 1e-9);
      // At the end the last step of the root is cut off: sqrt(2 jerk gap) with a gap of less than one step.
      EXPECT_GE(acceleration - before, -2.0 * kLimits.jerk * kStep - 1e-9);
      before = acceleration;
    }
    EXPECT_EQ(ramp.speed(), sign * 0.6);
  }
}

// 0.6 / 0.5 s of acceleration and 0.5 / 2 s to build it up: trapezoid of Biagiotti & Melchiorri, Trajectory Planning
// for Automatic Machines and Robots, 2008, section 3.4.
TEST(Ramp, TakesAsLongAsTheSCurve) {
  Ramp ramp(kLimits);
  double t = 0.0;
  for (; ramp.speed() < 0.6 - 1e-3; t += kStep) ramp.advance(0.6, kStep);
  EXPECT_NEAR(t, 0.6 / 0.5 + 0.5 / 2.0, 0.08);
}

TEST(Ramp, AStopIsExemptFromTheJerk) {
  Ramp ramp(kLimits);
  drive(ramp, 0.6, 3.0);
  EXPECT_NEAR(ramp.advance(0.0, kStep), 0.6 - 1.5 * kStep, 1e-12);
  EXPECT_EQ(drive(ramp, 0.0, 0.4).back(), 0.0);
}

TEST(Ramp, ReversingStopsAtZeroFirst) {
  Ramp ramp(kLimits);
  drive(ramp, 0.2, 2.0);
  const std::vector<double> speeds = drive(ramp, -0.2, 2.0);
  EXPECT_NE(std::find(speeds.begin(), speeds.end(), 0.0), speeds.end());
  EXPECT_EQ(speeds.back(), -0.2);
}

// 20 requests per second, each one step of the acceleration further: the shipped jerk lets them pass as they are.
TEST(Ramp, WithTheShippedJerkRequestsOfTheControllerPassUnchanged) {
  Ramp ramp({0.5, 1.5, 12.0});
  for (int i = 1; i <= 24; ++i) EXPECT_DOUBLE_EQ(ramp.advance(0.025 * i, 0.05), 0.025 * i);
}

}  // namespace
}  // namespace seater_safety
