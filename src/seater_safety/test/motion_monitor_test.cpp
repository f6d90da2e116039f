// A chair behind the gate's output, which obeys it with delay, lag, gain and slope, or does not.
#include "seater_safety/motion_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "seater_safety/ramp.h"

namespace seater_safety {
namespace {

constexpr double kStep = 0.02;  // [s] of the gate's output and of the odometry
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
using Fault = std::function<Velocity(const Velocity& told, const Velocity& moves)>;

Velocity obeys(const Velocity& told, const Velocity&) {
  return told;
}

class MotionMonitorTest : public testing::Test {
 protected:
  // Seconds until the fault, within `duration`; infinite: none. `wanted` goes through the gate's ramps.
  double drive(const Velocity& wanted, double duration, const Fault& fault = obeys) {
    for (double t = 0.0; t < duration; t += kStep, now_ += kStep) {
      const Velocity told{linear_.advance(wanted.linear, kStep), angular_.advance(wanted.angular, kStep)};
      monitor_.sent(now_, told);
      move(fault(delayed(told), moves_));
      if (monitor_.measured(now_, moves_)) return t;
    }
    return std::numeric_limits<double>::infinity();
  }

  Velocity delayed(const Velocity& told) {
    pipe_.push_back(told);
    if (pipe_.size() <= static_cast<std::size_t>(std::lround(delay_ / kStep))) return {};
    const Velocity arrived = pipe_.front();
    pipe_.pop_front();
    return arrived;
  }

  void move(const Velocity& motors) {
    moves_.linear += (gain_ * motors.linear + slope_ - moves_.linear) * kStep / lag_;
    moves_.angular += (gain_ * motors.angular - moves_.angular) * kStep / lag_;
  }

  void expectNoFault(double duration) {
    EXPECT_EQ(drive({0.6, 0.4}, duration), std::numeric_limits<double>::infinity());
    EXPECT_EQ(drive({0.15, -0.8}, duration), std::numeric_limits<double>::infinity());
    EXPECT_EQ(drive({}, duration), std::numeric_limits<double>::infinity());
    EXPECT_EQ(drive({-0.3, 0.8}, duration), std::numeric_limits<double>::infinity());
    EXPECT_EQ(drive({0.3, 0.0}, duration), std::numeric_limits<double>::infinity());
    EXPECT_EQ(monitor_.fault().reason, "");
  }

  GateParameters p_;
  MotionMonitor monitor_{p_};
  Ramp linear_{{p_.a_max, p_.a_stop, p_.jerk_max}};
  Ramp angular_{{p_.alpha_max, p_.alpha_stop, p_.angular_jerk_max}};
  double delay_ = 0.25, lag_ = 0.3;   // [s]
  double gain_ = 1.05, slope_ = 0.0;  // slope_ [m/s]: faster by this, downhill
  double now_ = 100.0;
  std::deque<Velocity> pipe_;
  Velocity moves_;
};

TEST_F(MotionMonitorTest, AChairThatObeysBringsNoFault) {
  expectNoFault(0.5);
  expectNoFault(3.0);
}

TEST_F(MotionMonitorTest, NorOneOnASlopeOrOneThatIsFasterThanToldWithinTheBounds) {
  for (const double slope : {0.05, -0.05}) {
    slope_ = slope;
    expectNoFault(2.0);
  }
  slope_ = 0.0;
  gain_ = 1.3;
  expectNoFault(2.0);
}

TEST_F(MotionMonitorTest, BrakingIsNoFaultThoughItTakesTime) {
  delay_ = 0.3;
  lag_ = 0.5;
  for (const double v : {0.6, -0.3}) {
    EXPECT_EQ(drive({v, 0.8}, 3.0), std::numeric_limits<double>::infinity());
    EXPECT_EQ(drive({}, 4.0), std::numeric_limits<double>::infinity());
  }
}

TEST_F(MotionMonitorTest, ARunawayFromStandstillIsNoticed) {
  const double found = drive({}, 3.0, [](const Velocity&, const Velocity&) { return Velocity{0.4, 0.0}; });
  EXPECT_LE(found, 0.35);
  EXPECT_GE(found, p_.motion_time) << "not by a single value";
  EXPECT_NE(monitor_.fault().reason.find("drives at 0."), std::string::npos) << monitor_.fault().reason;
}

TEST_F(MotionMonitorTest, ARunawayInTheBayIsNoticed) {
  drive({0.14, 0.0}, 2.0);
  EXPECT_LE(drive({0.14, 0.0}, 3.0, [](const Velocity&, const Velocity&) { return Velocity{0.4, 0.0}; }), 0.6);
}

TEST_F(MotionMonitorTest, ATurnThatNobodyAskedForIsNoticed) {
  EXPECT_LE(drive({}, 3.0, [](const Velocity&, const Velocity&) { return Velocity{0.0, -0.8}; }), 0.5);
  EXPECT_NE(monitor_.fault().reason.find("turns at -0."), std::string::npos) << monitor_.fault().reason;
}

TEST_F(MotionMonitorTest, AChairThatKeepsTheLastCommandIsNoticed) {
  for (const double v : {0.5, 0.14, -0.25}) {
    monitor_ = MotionMonitor(p_);
    drive({v, 0.0}, 3.0);
    const double braking = std::abs(v) / p_.a_stop;
    const double found = drive({}, 4.0, [](const Velocity&, const Velocity& moves) { return moves; });
    EXPECT_LE(found, p_.motion_delay + braking + p_.motion_speed / (0.5 * p_.a_max) + p_.motion_time + 0.1) << v;
  }
}

// Long before its speed would say so: 0.4 m/s are allowed for all of this time. Also one that is told so gently, as
// into a bay.
TEST_F(MotionMonitorTest, AChairThatDoesNotSlowDownAsToldIsNoticed) {
  for (const auto& [rate, window] : {std::pair{0.3, 0.08 / 0.3}, std::pair{0.18, 0.1 / 0.18}}) {
    monitor_ = MotionMonitor(p_);
    drive({0.6, 0.0}, 4.0);
    double v = 0.6;
    double found = 0.0;
    for (; found < 3.0 && monitor_.fault().reason.empty(); found += kStep, v = std::max(0.15, v - rate * kStep)) {
      drive({v, 0.0}, kStep, [this](const Velocity&, const Velocity& moves) {
        return Velocity{moves.linear / gain_, 0.0};
      });
    }
    EXPECT_LE(found, p_.motion_delay + window + 0.1 + 0.1) << rate;
    EXPECT_NE(monitor_.fault().reason.find("does not slow down"), std::string::npos) << monitor_.fault().reason;
    EXPECT_EQ(monitor_.fault().cause, GateState::kRunaway);
  }
}

// A slow chair (delay 0.4 s, lag 0.3 s) that comes onto a ramp downhill while it slows down.
TEST_F(MotionMonitorTest, OneThatSlowsDownLateAndLittleIsNot) {
  delay_ = 0.4;
  gain_ = 1.0;
  for (const double rate : {0.12, 0.15, 0.18, 0.25, 0.3, 0.4, 0.5}) {
    drive({0.6, 0.0}, 4.0);
    slope_ = 0.05;
    for (double v = 0.6; v > 0.15; v -= rate * kStep) drive({v, 0.0}, kStep);
    drive({0.15, 0.0}, 2.0);
    slope_ = 0.0;
    EXPECT_EQ(monitor_.fault().reason, "") << rate;
  }
}

// Recorded: a worn chair (delay 0.43 s, lag 0.29 s) still speeds up by what it was told half a second ago.
TEST_F(MotionMonitorTest, NorOneThatIsToldToSlowDownBeforeItHasSpedUp) {
  const std::vector<std::pair<double, double>> measured = {
      {22.98, 0.108}, {23.05, 0.136}, {23.14, 0.174}, {23.22, 0.210}, {23.29, 0.244}, {23.37, 0.277},
      {23.46, 0.292}, {23.52, 0.292}, {23.61, 0.285}, {23.68, 0.269}, {23.77, 0.249}, {23.84, 0.228}};
  double now = 21.98;
  for (const auto& [time, v] : measured) {
    for (; now < time; now += kStep) {
      monitor_.sent(now, {std::min(0.405 - 0.5 * (22.78 - now), 0.405 - 0.46 * (now - 22.78)), 0.0});
    }
    EXPECT_FALSE(monitor_.measured(time, {v, 0.0})) << time << monitor_.fault().reason;
  }
}

TEST_F(MotionMonitorTest, OdometryWithoutSpeedsBringsNoFault) {
  const auto blind = [this](double) { return monitor_.measured(now_, {}); };
  for (double v = 0.6; v > 0.0; v -= 0.5 * kStep, now_ += kStep) {
    monitor_.sent(now_, {v, 0.0});
    EXPECT_FALSE(blind(v));
  }
}

TEST_F(MotionMonitorTest, OneMotorWithoutPowerIsNoticed) {
  constexpr double kTrack = 0.56;
  const auto right_alone = [](const Velocity& told, const Velocity&) {
    const double right = told.linear + 0.5 * kTrack * told.angular;
    return Velocity{0.5 * right, right / kTrack};
  };
  gain_ = 1.0;
  for (const double v : {0.15, -0.15}) {
    monitor_ = MotionMonitor(p_);
    moves_ = {};
    drive({v, 0.0}, 3.0);
    EXPECT_LE(drive({v, 0.0}, 3.0, right_alone), delay_ + lag_ + 0.3 + 0.1) << v;
    EXPECT_NE(monitor_.fault().reason.find("a motor without power"), std::string::npos) << monitor_.fault().reason;
  }
}

// Castors that lie across turn a chair by up to 0.15 rad/s and take 0.025 m/s; a slope takes 0.03 m/s more.
TEST_F(MotionMonitorTest, CastorsThatTurnTheChairAreNoMotorWithoutPower) {
  gain_ = 1.0;
  drive({0.15, 0.0}, 3.0);
  const auto pushed = [](const Velocity& told, const Velocity&) { return Velocity{told.linear - 0.045, 0.15}; };
  EXPECT_EQ(drive({0.15, 0.0}, 2.0, pushed), std::numeric_limits<double>::infinity()) << monitor_.fault().reason;
}

TEST_F(MotionMonitorTest, NorIsOneThatTurnsLate) {
  delay_ = 0.4;
  gain_ = 0.6;
  drive({0.2, 0.8}, 3.0);
  drive({0.2, -0.8}, 3.0);
  EXPECT_EQ(monitor_.fault().reason, "");
}

TEST_F(MotionMonitorTest, WhatSomebodyElseHasNoticedLastsAsLong) {
  drive({}, 2.0);
  EXPECT_TRUE(monitor_.told({GateState::kWrongDirection, "why"}));
  EXPECT_FALSE(monitor_.told({GateState::kRunaway, "later"}));
  EXPECT_EQ(monitor_.fault().cause, GateState::kWrongDirection);
  drive({}, 0.9);
  EXPECT_EQ(monitor_.fault().reason, "why");
  drive({}, 0.3);
  EXPECT_EQ(monitor_.fault().reason, "");
  EXPECT_TRUE(monitor_.told({GateState::kRunaway, ""}));
  EXPECT_NE(monitor_.fault().reason, "") << "a fault without words is one";
}

TEST_F(MotionMonitorTest, TheWrongWayIsNoticed) {
  const auto reversed = [](const Velocity& told, const Velocity&) { return Velocity{-told.linear, told.angular}; };
  EXPECT_LE(drive({0.1, 0.0}, 3.0, reversed), 1.6) << "too slow for a runaway";
  EXPECT_NE(monitor_.fault().reason.find("wrong way"), std::string::npos) << monitor_.fault().reason;
}

TEST_F(MotionMonitorTest, TheWrongTurnIsNoticed) {
  const auto reversed = [](const Velocity& told, const Velocity&) { return Velocity{told.linear, -told.angular}; };
  EXPECT_LE(drive({0.0, 0.3}, 3.0, reversed), 1.8);
  EXPECT_NE(monitor_.fault().reason.find("told 0.30"), std::string::npos) << monitor_.fault().reason;
}

TEST_F(MotionMonitorTest, AFaultLastsUntilTheChairHasStoodForASecond) {
  ASSERT_LE(drive({}, 3.0, [](const Velocity&, const Velocity&) { return Velocity{0.4, 0.0}; }), 1.0);
  moves_ = {};
  drive({}, 0.8);
  moves_ = {0.05, 0.0};
  drive({}, 0.06);
  moves_ = {};
  drive({}, 0.9);
  EXPECT_NE(monitor_.fault().reason, "") << "it moved in between";
  drive({}, 0.3);
  EXPECT_EQ(monitor_.fault().reason, "");
}

TEST_F(MotionMonitorTest, WithoutOdometryItIsOff) {
  EXPECT_FALSE(monitor_.watches(now_));
  for (int i = 0; i < 100; ++i, now_ += kStep) EXPECT_FALSE(monitor_.measured(now_, {kNan, 0.0}));
  EXPECT_FALSE(monitor_.watches(now_)) << "what is not finite is no odometry";
  EXPECT_FALSE(monitor_.measured(now_, {}));
  EXPECT_TRUE(monitor_.watches(now_ + 0.4));
  EXPECT_FALSE(monitor_.watches(now_ + 0.6));
}

// A gate that starts, or odometry that comes back, while the chair is braking.
TEST_F(MotionMonitorTest, TheFirstSpeedAfterAPauseCountsAsExplained) {
  moves_ = {0.5, 0.0};
  EXPECT_EQ(drive({}, 3.0), std::numeric_limits<double>::infinity());
  moves_ = {0.5, 0.0};
  now_ += 1.0;
  const double found = drive({}, 3.0, [](const Velocity&, const Velocity& moves) { return moves; });
  EXPECT_LE(found, 0.6) << "it has to brake";
  EXPECT_GE(found, p_.motion_time + 0.1) << "what was before the pause counts no more";
}

}  // namespace
}  // namespace seater_safety
