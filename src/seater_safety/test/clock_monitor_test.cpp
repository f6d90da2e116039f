#include "seater_safety/clock_monitor.h"

#include <gtest/gtest.h>

#include <functional>

namespace seater_safety {
namespace {

// Runs both clocks for `duration` [s] at 50 Hz; returns when the first fault was seen [s], -1: never.
double firstFault(ClockMonitor& monitor, double begin, double duration, const std::function<double(double)>& other) {
  for (double t = 0.0; t < duration; t += 0.02) {
    if (!monitor.check(begin + t, other(t)).empty()) return t;
  }
  return -1.0;
}

TEST(ClockMonitor, ClocksThatRunAlikeAreFine) {
  ClockMonitor monitor;
  EXPECT_EQ(firstFault(monitor, 5.0, 60.0, [](double t) { return 1.7e9 + t; }), -1.0);
}

TEST(ClockMonitor, AClockThatIsDisciplinedIsFine) {
  ClockMonitor monitor;
  EXPECT_EQ(firstFault(monitor, 5.0, 60.0, [](double t) { return 1.7e9 + 1.083 * t; }), -1.0);
}

TEST(ClockMonitor, AClockThatStandsIsFoundSoonAndForAsLongAsItStands) {
  ClockMonitor monitor;
  const double found = firstFault(monitor, 5.0, 2.0, [](double) { return 100.0; });
  EXPECT_GT(found, 0.2);
  EXPECT_LT(found, 0.4);
  for (double t = found; t < 10.0; t += 0.02) EXPECT_FALSE(monitor.check(5.0 + t, 100.0).empty()) << t;
}

TEST(ClockMonitor, AJumpIsFoundAtOnceAndForgottenAfterASecond) {
  for (const double jump : {-3600.0, -0.5, 0.5, 3600.0}) {
    ClockMonitor monitor;
    const auto clock = [jump](double t) { return 100.0 + t + (t > 0.99 ? jump : 0.0); };
    EXPECT_NEAR(firstFault(monitor, 5.0, 3.0, clock), 1.0, 0.021) << jump;
    EXPECT_EQ(firstFault(monitor, 7.1, 5.0, [&clock](double t) { return clock(2.1 + t); }), -1.0) << jump;
  }
}

TEST(ClockMonitor, SaysHowFar) {
  ClockMonitor monitor;
  monitor.check(5.0, 100.0);
  EXPECT_EQ(monitor.check(5.0, 103.5), "the clock of ROS stands, jumps or was set: +3.5 s");
}

}  // namespace
}  // namespace seater_safety
