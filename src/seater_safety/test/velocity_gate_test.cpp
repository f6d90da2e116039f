#include "seater_safety/velocity_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace seater_safety {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const std::string kDocking = "/docking";

// Asks for the same velocity at 20 Hz for `duration` and returns the last output.
Velocity ask(VelocityGate& gate, double& now, double duration, const Velocity& velocity) {
  Velocity output;
  for (const double end = now + duration; now < end; now += 0.05) {
    gate.request(now, kDocking, velocity);
    output = gate.output(now);
  }
  return output;
}

// The same, with a new consent where none is held.
Velocity hold(VelocityGate& gate, double& now, double duration, const Velocity& velocity) {
  gate.output(now);
  if (!gate.status(now).motion_allowed) {
    EXPECT_FALSE(gate.arm(now, kDocking).has_value());
  }
  return ask(gate, now, duration, velocity);
}

TEST(VelocityGate, IsZeroUntilSomebodyAsks) {
  VelocityGate gate{GateParameters{}};
  const Velocity output = gate.output(10.0);
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(output.angular, 0.0);
  EXPECT_EQ(gate.state(), GateState::kStopped);
}

TEST(VelocityGate, LetsAPermittedRequestThrough) {
  VelocityGate gate{GateParameters{}};
  double now = 1.0;
  const Velocity output = hold(gate, now, 2.0, {0.3, -0.4});
  EXPECT_DOUBLE_EQ(output.linear, 0.3);
  EXPECT_DOUBLE_EQ(output.angular, -0.4);
  EXPECT_EQ(gate.limited(), 0u);
}

TEST(VelocityGate, LimitsSpeedOfEachAxisByItsOwnLimit) {
  VelocityGate gate{GateParameters{}};
  double now = 1.0;
  EXPECT_DOUBLE_EQ(hold(gate, now, 4.0, {5.0, 5.0}).linear, 0.6);
  EXPECT_DOUBLE_EQ(gate.output(now).angular, 0.8);
  EXPECT_DOUBLE_EQ(hold(gate, now, 4.0, {-5.0, -5.0}).linear, -0.3);
  EXPECT_DOUBLE_EQ(gate.output(now).angular, -0.8);
  EXPECT_GT(gate.limited(), 0u);
}

TEST(VelocityGate, SpeedsUpWithinTheAccelerationLimit) {
  const GateParameters p;
  VelocityGate gate{p};
  double previous = gate.output(0.0).linear;
  gate.arm(0.0, kDocking);
  for (double now = 0.05; now < 3.0; now += 0.05) {
    gate.request(now, kDocking, {0.6, 0.0});
    const double linear = gate.output(now).linear;
    EXPECT_LE(linear - previous, p.a_max * 0.05 + 1e-12);
    previous = linear;
  }
  EXPECT_DOUBLE_EQ(previous, 0.6);
}

TEST(VelocityGate, APauseIsNoLicenceToJump) {
  VelocityGate gate{GateParameters{}};
  gate.output(0.0);
  gate.arm(100.0, kDocking);
  gate.request(100.0, kDocking, {0.6, 0.0});
  EXPECT_LE(gate.output(100.0).linear, 0.05 + 1e-12);
}

// Its process stood still for 3 s and went on: the chair, which had stopped by itself, drove on from 0.3 m/s downward.
TEST(VelocityGate, AfterASilenceThatStopsTheBaseItBeginsAtZero) {
  const GateParameters p;
  for (const double asked : {0.0, 0.6}) {
    VelocityGate gate{p};
    double now = 0.0;
    EXPECT_GT(hold(gate, now, 2.0, {0.6, 0.5}).linear, 0.5);
    now += 0.35;
    gate.request(now, kDocking, {asked, asked});
    const Velocity output = gate.output(now);
    EXPECT_EQ(output.linear, 0.0);
    EXPECT_EQ(output.angular, 0.0);
    EXPECT_LE(hold(gate, now, 0.1, {asked, asked}).linear, 0.1 * p.a_max);
  }
}

TEST(VelocityGate, StopsWhenRequestsEnd) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.5});
  const double end = now + p.request_timeout + 0.6 / p.a_stop + 0.05;
  Velocity output{1.0, 1.0};
  for (; now < end; now += 0.02) output = gate.output(now);
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(output.angular, 0.0);
}

TEST(VelocityGate, AZeroRequestIsServedByTheStoppingLimit) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.0});
  EXPECT_GT(hold(gate, now, 0.3, {}).linear, 0.0);
  EXPECT_EQ(hold(gate, now, 0.2, {}).linear, 0.0);
}

TEST(VelocityGate, WhatIsNotFiniteStopsTheChair) {
  for (const Velocity& bad : {Velocity{kNan, 0.0}, Velocity{0.0, kNan}, Velocity{kInf, 0.0}, Velocity{0.1, -kInf}}) {
    VelocityGate gate{GateParameters{}};
    double now = 0.0;
    hold(gate, now, 2.0, {0.6, 0.5});
    gate.request(now, kDocking, bad);
    now += 0.05;
    const Velocity first = gate.output(now);
    EXPECT_TRUE(std::isfinite(first.linear) && std::isfinite(first.angular));
    EXPECT_LT(first.linear, 0.6);
    EXPECT_EQ(gate.state(), GateState::kRefused);
    const Velocity last = ask(gate, now, 1.0, bad);
    EXPECT_EQ(last.linear, 0.0);
    EXPECT_EQ(last.angular, 0.0);
    EXPECT_GT(gate.refused(), 0u);
  }
}

TEST(VelocityGate, ReversingPassesThroughZero) {
  VelocityGate gate{GateParameters{}};
  double now = 0.0;
  double previous = hold(gate, now, 2.0, {0.2, 0.0}).linear;
  bool stood = false;
  for (int i = 0; i < 20; ++i) {
    const double linear = hold(gate, now, 0.05, {-0.2, 0.0}).linear;
    stood = stood || (previous > 0.0 && linear == 0.0);
    previous = linear;
  }
  EXPECT_TRUE(stood);
}

// Lock-step: the clock's message of this step may be read before or after the request that carries its stamp.
TEST(VelocityGate, DoesTheSameWhetherTheClockOrTheRequestIsReadFirst) {
  VelocityGate prompt{GateParameters{}};
  VelocityGate late{GateParameters{}};
  prompt.arm(0.0, kDocking);
  late.arm(0.0, kDocking);
  for (int cycle = 1; cycle < 40; ++cycle) {
    const double stamp = 0.05 * cycle;
    const double behind = cycle % 3 == 0 ? stamp - 0.03 : stamp;
    const Velocity asked{0.6, -0.8};
    const double now = VelocityGate::requestTime(behind, stamp);
    prompt.request(stamp, kDocking, asked);
    late.request(now, kDocking, asked);
    const Velocity expected = prompt.output(stamp);
    const Velocity found = late.output(now);
    EXPECT_EQ(found.linear, expected.linear) << stamp;
    EXPECT_EQ(found.angular, expected.angular) << stamp;
    late.output(behind);  // the timer, whose clock is still behind, changes nothing
  }
}

TEST(VelocityGate, DoesNotBelieveAStampFarInTheFuture) {
  EXPECT_EQ(VelocityGate::requestTime(5.0, 5.2), 5.2);
  EXPECT_EQ(VelocityGate::requestTime(5.0, 4.0), 5.0);
  EXPECT_EQ(VelocityGate::requestTime(5.0, 9.0), 5.0);
  EXPECT_EQ(VelocityGate::requestTime(5.0, kInf), 5.0);
  EXPECT_EQ(VelocityGate::requestTime(5.0, kNan), 5.0);
}

TEST(VelocityGate, StopsWhenTheClockJumpsBackward) {
  VelocityGate gate{GateParameters{}};
  double now = 1000.0;
  ASSERT_GT(hold(gate, now, 2.0, {0.5, 0.2}).linear, 0.4);
  Velocity output;
  for (double restarted = 1.0; restarted < 2.0; restarted += 0.02) output = gate.output(restarted);
  EXPECT_EQ(output.linear, 0.0);
  EXPECT_EQ(output.angular, 0.0);
  double again = 2.0;
  EXPECT_GT(hold(gate, again, 2.0, {0.5, 0.0}).linear, 0.4);
}

}  // namespace
}  // namespace seater_safety
