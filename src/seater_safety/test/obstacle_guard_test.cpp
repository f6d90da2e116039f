#include "seater_safety/obstacle_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "seater_safety/velocity_gate.h"

namespace seater_safety {
namespace {

const std::string kScan = "scan";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const GateParameters kDefault;
const double kFront = kDefault.length_front, kHalf = 0.5 * kDefault.width, kMargin = kDefault.obstacle_margin;

Velocity limited(const std::vector<Point>& points, const Velocity& wanted) {
  ObstacleGuard guard{kDefault};
  guard.seen(10.0, 10.0, kScan, points);
  return guard.limited(10.0, wanted);
}

TEST(ObstacleGuard, WhatIsNotOnTheWayDoesNotMatter) {
  for (const Point& point : {Point{kFront + 0.3, kHalf + kMargin + 0.01}, Point{kFront + 3.0, 0.0}, Point{-0.5, 0.0}}) {
    EXPECT_EQ(limited({point}, {0.6, 0.0}).linear, 0.6) << point.x << " " << point.y;
  }
  EXPECT_LT(limited({{kFront + 0.3, kHalf + kMargin - 0.01}}, {0.6, 0.0}).linear, 0.6);
  EXPECT_EQ(limited({{-kDefault.length_rear - 0.05, 0.0}}, {-0.3, 0.0}).linear, 0.0);
}

// From standstill: v hold + v^2 / (2 a_max) is the free way, to the pieces in which it is looked at.
TEST(ObstacleGuard, TheSpeedIsOneFromWhichTheChairStopsComfortably) {
  for (const double way : {0.1, 0.2, 0.3}) {
    const double v = limited({{kFront + kMargin + way, 0.1}}, {0.6, 0.0}).linear;
    EXPECT_LE(v * 0.05 + v * v / (2.0 * kDefault.a_max), way + 1e-9);
    EXPECT_GE(v * 0.05 + v * v / (2.0 * kDefault.a_max), way - 0.025);
  }
}

TEST(ObstacleGuard, TheArcOfTheCommandIsSweptAndKept) {
  // On the outside of the front corner as it turns left; a circle of 0.75 m radius.
  const Velocity left{0.3, 0.4};
  const Point ahead{kFront + 0.10, kHalf - 0.02}, aside{kFront + 0.10, -kHalf - kMargin};
  const Velocity output = limited({ahead}, left);
  EXPECT_LT(output.linear, left.linear);
  EXPECT_NEAR(output.angular * left.linear, output.linear * left.angular, 1e-12);
  EXPECT_EQ(limited({aside}, left).linear, left.linear);
  // Turning on the spot: the front corner, 0.82 m from the axle, meets what stands beside the chair.
  EXPECT_EQ(limited({{0.70, kHalf + 0.04}}, {0.0, 0.5}).angular, 0.0);
  EXPECT_EQ(limited({{0.70, kHalf + 0.04}}, {0.0, -0.5}).angular, -0.5);
  EXPECT_EQ(limited({{0.0, kHalf + 0.04}}, {0.0, 0.5}).angular, 0.5);
}

TEST(ObstacleGuard, TheWayOutStaysOpen) {
  const Point touching{kFront + 0.01, 0.0}, inside{kFront - 0.05, 0.0};
  for (const Point& point : {touching, inside}) {
    EXPECT_EQ(limited({point}, {0.2, 0.0}).linear, 0.0);
    EXPECT_EQ(limited({point}, {-0.2, 0.0}).linear, -0.2);
  }
  EXPECT_EQ(limited({{0.3, kHalf + 0.01}}, {0.5, 0.0}).linear, 0.5) << "along a wall";
}

TEST(ObstacleGuard, AgeAndDelayCountAsWayDriven) {
  const auto after = [](double age, double speed) {
    ObstacleGuard guard{kDefault};
    for (double t = 0.0; t <= 10.0; t += 0.02) guard.sent(t, {speed, 0.0});
    guard.seen(10.0, 10.0 - age, kScan, {{kFront + kMargin + 0.7, 0.0}});
    return guard.limited(10.0, {0.6, 0.0}).linear;
  };
  EXPECT_GT(after(0.0, 0.0), after(0.0, 0.6));
  EXPECT_GT(after(0.0, 0.6), after(0.3, 0.6));
  EXPECT_GT(after(0.4, 0.6), 0.0);
  EXPECT_EQ(after(0.0, 1.2), 0.0) << "1.2 m/s for motion_delay: the way is used up";
}

TEST(ObstacleGuard, TheNewestOfEachSourceCounts) {
  ObstacleGuard guard{kDefault};
  const std::vector<Point> ahead{{kFront + 0.04, 0.0}};
  guard.seen(10.0, 10.0, kScan, ahead);
  guard.seen(10.0, 10.0, "depth", {});
  EXPECT_EQ(guard.limited(10.0, {0.5, 0.0}).linear, 0.0);
  EXPECT_NE(guard.reason(), "");
  guard.seen(10.3, 10.1, kScan, {});  // counts from 10.3 on
  EXPECT_EQ(guard.limited(10.2, {0.5, 0.0}).linear, 0.0);
  EXPECT_EQ(guard.limited(10.3, {0.5, 0.0}).linear, 0.5);
  EXPECT_EQ(guard.reason(), "");
  guard.seen(11.0, 11.0, kScan, ahead);
  EXPECT_EQ(guard.limited(11.0 + kDefault.obstacle_timeout + 0.01, {0.5, 0.0}).linear, 0.5) << "nobody requires it";
}

TEST(ObstacleGuard, AfterAStopTheChairDoesNotCreepOn) {
  ObstacleGuard guard{kDefault};
  guard.seen(10.0, 10.0, kScan, {{kFront + 0.04, 0.0}});
  EXPECT_EQ(guard.limited(10.0, {0.5, 0.0}).linear, 0.0);
  EXPECT_EQ(guard.limited(10.0, {-0.2, 0.0}).linear, -0.2) << "the way out";
  guard.seen(10.1, 10.1, kScan, {{kFront + 0.2, 0.0}});
  EXPECT_EQ(guard.limited(10.4, {0.5, 0.0}).linear, 0.0);
  EXPECT_GT(guard.limited(10.55, {0.5, 0.0}).linear, 0.0);
}

TEST(ObstacleGuard, ASilentOldOrBlockedSourceIsBlind) {
  const double patience = kDefault.obstacle_timeout;
  ObstacleGuard guard{kDefault, {kScan}};
  EXPECT_EQ(guard.blind(10.0), "");
  EXPECT_EQ(guard.blind(10.0 + patience), "");
  EXPECT_EQ(guard.blind(10.01 + patience), "the sensor of obstacles (scan) is silent");
  guard.seen(10.6, 10.55, kScan, {});
  EXPECT_EQ(guard.blind(10.6), "");
  guard.seen(10.7, 10.7 - patience - 0.1, kScan, {});  // an old measurement again
  EXPECT_NE(guard.blind(10.7), "");
  guard.seen(10.8, -1.0 / 0.0, kScan, {});  // without a stamp
  EXPECT_NE(guard.blind(10.8), "");
  guard.seen(10.9, 10.9, kScan, {}, "no transform");
  EXPECT_EQ(guard.blind(10.9), "the sensor of obstacles (scan) sees nothing: no transform");
  guard.seen(11.0, 11.0, kScan, {{kNan, 0.0}});
  EXPECT_EQ(guard.blind(11.0), "the sensor of obstacles (scan) sees nothing: a point is not finite");
}

// Nobody takes the gate's time or memory by messages that no sensor of a chair sends.
TEST(ObstacleGuard, TooMuchIsBlind) {
  ObstacleGuard many{kDefault};
  many.seen(10.0, 10.0, kScan, std::vector<Point>(100000, Point{5.0, 5.0}));
  EXPECT_NE(many.blind(10.0).find("too many points"), std::string::npos);
  ObstacleGuard names{kDefault};
  for (int i = 0; i < 16; ++i) names.seen(10.0, 10.0, std::to_string(i), {});
  EXPECT_EQ(names.blind(10.0), "");
  for (int i = 16; i < 1000; ++i) names.seen(10.0 + 1e-3 * i, 10.0 + 1e-3 * i, std::to_string(i), {});
  EXPECT_NE(names.blind(11.0).find("too many sources"), std::string::npos);
}

TEST(ObstacleGuard, ASourceOfAnotherNameDoesNotReplaceTheRequiredOne) {
  ObstacleGuard guard{kDefault, {kScan}};
  for (double now = 10.0; now < 10.7; now += 0.1) {
    guard.seen(now, now, "depth", {});
    guard.blind(now);
  }
  EXPECT_NE(guard.blind(10.7), "");
}

// A chair that answers after `delay` [s] and brakes as it is told, towards a wall; the sensor is late, too.
double closest(double delay, double wanted, double appears) {
  VelocityGate gate{kDefault};
  std::vector<double> told;
  double x = 0.0, nearest = 1e9;
  EXPECT_FALSE(gate.arm(0.0, "/docking").has_value());
  std::vector<double> places;
  for (int i = 0; i < 1500; ++i) {
    const double now = 0.02 * i;
    const double wall = appears > 0.0 && x < appears ? 1e3 : 3.0;
    places.push_back(x);
    if (i % 5 == 0 && i >= 5) gate.obstacles(now, now - 0.1, kScan, {{kFront + wall - places[places.size() - 6], 0.0}});
    gate.request(now, "/docking", {wanted, 0.0});
    told.push_back(gate.output(now).linear);
    const int acts = i - static_cast<int>(delay / 0.02);
    if (acts >= 0) x += 0.02 * told[static_cast<std::size_t>(acts)];
    nearest = std::min(nearest, 3.0 - x);
  }
  EXPECT_EQ(told.back(), 0.0);
  EXPECT_EQ(gate.state(), GateState::kObstacle);
  return nearest;
}

TEST(ObstacleGuard, TheChairStopsShortOfAWallWhateverItsDelay) {
  for (const double delay : {0.0, 0.2, 0.4, 0.6}) {
    for (const double wanted : {0.15, 0.3, 0.6}) {
      const double left = closest(delay, wanted, 0.0);
      EXPECT_GE(left, kMargin) << delay << " " << wanted;
      EXPECT_LE(left, kMargin + 0.1) << delay << " " << wanted;
    }
  }
}

// What appears ahead: 0.6 m/s for 0.1 s of the sensor's age, one measurement and the delay, and 0.12 m of braking.
TEST(ObstacleGuard, TheChairStopsShortOfWhatAppears) {
  EXPECT_GT(closest(0.34, 0.6, 3.0 - 0.50), 0.0);
  EXPECT_LT(closest(0.34, 0.6, 3.0 - 0.20), 0.0) << "it cannot: physics";
}

TEST(ObstacleGuard, TheGateSaysSoAndDrivesOnWhenTheWayIsFree) {
  VelocityGate gate{kDefault};
  ASSERT_FALSE(gate.arm(10.0, "/docking").has_value());
  gate.obstacles(10.0, 10.0, kScan, {{kFront + 0.04, 0.0}});
  gate.request(10.0, "/docking", {0.3, 0.0});
  EXPECT_EQ(gate.output(10.0).linear, 0.0);
  EXPECT_EQ(gate.state(), GateState::kObstacle);
  EXPECT_NE(gate.status(10.0).reason.find("something is in the way"), std::string::npos);
  EXPECT_TRUE(gate.status(10.0).motion_allowed);
  gate.obstacles(10.1, 10.1, kScan, {});
  gate.request(10.1, "/docking", {0.3, 0.0});
  EXPECT_GT(gate.output(10.1).linear, 0.0);
  EXPECT_EQ(gate.state(), GateState::kRequest);
}

TEST(ObstacleGuard, ARequiredSourceThatFallsSilentEndsTheConsent) {
  VelocityGate gate{kDefault, {kScan}};
  double now = 10.0;
  gate.obstacles(now, now, kScan, {});
  gate.output(now);
  ASSERT_FALSE(gate.arm(now, "/docking").has_value());
  Velocity output;
  for (; now < 10.4; now += 0.05) {
    gate.request(now, "/docking", {0.3, 0.0});
    output = gate.output(now);
  }
  EXPECT_GT(output.linear, 0.05);
  for (; now < 11.5; now += 0.05) {
    gate.request(now, "/docking", {0.3, 0.0});
    output = gate.output(now);
  }
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(gate.state(), GateState::kObstacle);
  EXPECT_EQ(gate.status(now).stopped_by, GateState::kObstacle);
  gate.request(now, "/docking", {});
  EXPECT_EQ(gate.arm(now + 0.3, "/docking")->state, GateState::kObstacle);
  gate.obstacles(now + 0.4, now + 0.4, kScan, {});
  EXPECT_EQ(gate.output(now + 0.4).linear, 0.0) << "needs a new consent";
  EXPECT_FALSE(gate.arm(now + 0.4, "/docking").has_value());
}

TEST(ObstacleGuard, TheJoystickIsStoppedWhereTheParameterSaysSo) {
  for (const double watched : {1.0, 0.0}) {
    GateParameters p;
    p.obstacle_joystick = watched;
    VelocityGate gate{p, {kScan}};
    double now = 10.0;
    gate.output(now);
    gate.user(now += 0.1, {});
    for (; now < 12.0; now += 0.05) {
      gate.obstacles(now, now, kScan, {{kFront + 0.04, 0.0}});
      gate.user(now, {0.3, 0.0});
      gate.output(now);
    }
    EXPECT_EQ(gate.output(now).linear, watched == 1.0 ? 0.0 : 0.3);
    EXPECT_EQ(gate.state(), watched == 1.0 ? GateState::kObstacle : GateState::kUser);
    for (; now < 14.0; now += 0.05) {  // the sensor has gone: who sits in the chair sees the way
      gate.user(now, {0.3, 0.0});
      gate.output(now);
    }
    EXPECT_EQ(gate.output(now).linear, 0.3);
  }
}

}  // namespace
}  // namespace seater_safety
