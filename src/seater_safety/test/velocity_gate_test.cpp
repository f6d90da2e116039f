#include "seater_safety/velocity_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace seater_safety {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// Asks for the same velocity at 20 Hz for `duration` and returns the last output.
Velocity hold(VelocityGate& gate, double& now, double duration, const Velocity& velocity) {
  Velocity output;
  for (const double end = now + duration; now < end; now += 0.05) {
    gate.request(now, velocity);
    output = gate.output(now);
  }
  return output;
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
  for (double now = 0.05; now < 3.0; now += 0.05) {
    gate.request(now, {0.6, 0.0});
    const double linear = gate.output(now).linear;
    EXPECT_LE(linear - previous, p.a_max * 0.05 + 1e-12);
    previous = linear;
  }
  EXPECT_DOUBLE_EQ(previous, 0.6);
}

TEST(VelocityGate, APauseIsNoLicenceToJump) {
  VelocityGate gate{GateParameters{}};
  gate.output(0.0);
  gate.request(100.0, {0.6, 0.0});
  EXPECT_LE(gate.output(100.0).linear, 0.05 + 1e-12);
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
    gate.request(now, bad);
    const Velocity first = gate.output(now);
    EXPECT_TRUE(std::isfinite(first.linear) && std::isfinite(first.angular));
    EXPECT_LT(first.linear, 0.6);
    EXPECT_EQ(gate.state(), GateState::kRefused);
    const Velocity last = hold(gate, now, 1.0, bad);
    EXPECT_EQ(last.linear, 0.0);
    EXPECT_EQ(last.angular, 0.0);
    EXPECT_GT(gate.refused(), 0u);
  }
}

TEST(VelocityGate, TheJoystickRulesWhileItIsFresh) {
  const GateParameters p;
  VelocityGate gate{p};
  double now = 0.0;
  hold(gate, now, 2.0, {0.5, 0.0});
  gate.user(now, {-0.1, 0.0});
  hold(gate, now, 0.45, {0.5, 0.0});
  EXPECT_EQ(gate.state(), GateState::kUser);
  EXPECT_LE(gate.output(now).linear, 0.0);
  EXPECT_GT(hold(gate, now, 1.0, {0.5, 0.0}).linear, 0.3);
  EXPECT_EQ(gate.state(), GateState::kRequest);
}

TEST(VelocityGate, EmergencyStopOverrulesAll) {
  VelocityGate gate{GateParameters{}};
  double now = 0.0;
  hold(gate, now, 2.0, {0.6, 0.5});
  gate.emergencyStop(true);
  gate.user(now, {0.3, 0.0});
  EXPECT_EQ(hold(gate, now, 1.0, {0.6, 0.5}).linear, 0.0);
  EXPECT_EQ(gate.state(), GateState::kEmergencyStop);
  gate.emergencyStop(false);
  EXPECT_GT(hold(gate, now, 2.0, {0.6, 0.5}).linear, 0.5);
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

TEST(VelocityGate, RefusesParametersThatAreNotPositive) {
  GateParameters p;
  p.a_stop = 0.0;
  EXPECT_THROW(VelocityGate{p}, std::invalid_argument);
  p = GateParameters{};
  p.request_timeout = kNan;
  EXPECT_NE(p.check().find("request_timeout"), std::string::npos);
}

// Lock-step: the clock's message of this step may be read before or after the request that carries its stamp.
TEST(VelocityGate, DoesTheSameWhetherTheClockOrTheRequestIsReadFirst) {
  VelocityGate prompt{GateParameters{}};
  VelocityGate late{GateParameters{}};
  for (int cycle = 1; cycle < 40; ++cycle) {
    const double stamp = 0.05 * cycle;
    const double behind = cycle % 3 == 0 ? stamp - 0.03 : stamp;
    const Velocity asked{0.6, -0.8};
    const double now = VelocityGate::requestTime(behind, stamp);
    prompt.request(stamp, asked);
    late.request(now, asked);
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

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
